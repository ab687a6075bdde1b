"""Simplifies meshes, so that the page opens and turns quickly.

All meshes of a robot share a tolerance, since they are seen from the same distance: triangles stay where the
shape needs them, and small parts lose theirs first. manifold3d simplifies within the tolerance; meshes that
it rejects, or hardly simplifies, are clustered: the points in each cell of a grid are merged.
"""

import functools
from collections.abc import Hashable, Mapping
from typing import TypeVar

import numpy as np

from linkwright.stages.formats.meshes.surface import weld
from linkwright.stages.show.clusters import cell_means
from linkwright.stages.show.decimate import Simplifiable, lowest_level
from linkwright.stages.show.live.triangles import Corners, Facets

_MIN_TOLERANCE = 2e-5
"""The finest tolerance, as a share of the size of the largest mesh; each level doubles the tolerance."""

_CLUSTER_TOLERANCE = 2e-2
"""The tolerance, as the same share, with which clustering starts if no level has few enough triangles."""

_MAX_TOLERANCE = 5e-2
"""The coarsest tolerance, as the same share."""

_MAX_FINE_EXCESS = 2
"""If there are at most this many times too many triangles, the search starts at a fine level."""

_MIN_TRIANGLES = 12
"""Meshes with at most this many triangles stay unchanged."""

Key = TypeVar("Key", bound=Hashable)


def simplify_to_budget(
    meshes: Mapping[Key, Facets], uses: Mapping[Key, int], max_triangles: int
) -> dict[Key, Facets]:
    """Simplifies the meshes until they have at most `max_triangles` triangles together, counting each of
    their `uses`. If no tolerance is enough, the smallest meshes lose all triangles."""
    simpler = dict(meshes)
    if _total(simpler, uses) <= max_triangles:
        return simpler
    size = max(facets.size for facets in simpler.values())
    solids = {key: SimplifiableMesh(facets) for key, facets in simpler.items()}

    def at_level(level: int) -> dict[Key, Facets]:
        return {key: solid.simpler(_MIN_TOLERANCE * 2.0**level * size) for key, solid in solids.items()}

    last = int(np.log2(_MAX_TOLERANCE / _MIN_TOLERANCE))
    is_near = _total(simpler, uses) <= _MAX_FINE_EXCESS * max_triangles
    # Only the coarsest level shows whether any level is enough. It takes longest, so it is not tried first if
    # little must be lost.
    if is_near or _total(at_level(last), uses) <= max_triangles:
        first = last // 4 if is_near else None
        level = lowest_level(last + 1, lambda number: _total(at_level(number), uses), max_triangles, first)
        if level <= last:
            finer = at_level(level - 1) if level else simpler
            return _restored(at_level(level), finer, uses, max_triangles)
    return _cluster_to_budget(at_level(last), uses, max_triangles, size)


def _cluster_to_budget(
    meshes: dict[Key, Facets], uses: Mapping[Key, int], max_triangles: int, size: float
) -> dict[Key, Facets]:
    """Clusters the meshes at growing tolerances until they have at most `max_triangles`. If no tolerance is
    enough, the smallest meshes lose all triangles. `size` [m]: the size of the largest mesh."""
    simpler, cluster_share = meshes, _CLUSTER_TOLERANCE
    while cluster_share <= _MAX_TOLERANCE:
        finer = simpler
        simpler = {key: clustered(facets, cluster_share * size) for key, facets in finer.items()}
        if _total(simpler, uses) <= max_triangles:
            return _restored(simpler, finer, uses, max_triangles)
        cluster_share *= 2.0
    return _emptied(simpler, uses, max_triangles)


class SimplifiableMesh:
    """A mesh, prepared once for all tolerances."""

    def __init__(self, facets: Facets) -> None:
        self._facets = facets
        self._by_tolerance: dict[float, Facets] = {}

    @functools.cached_property
    def _solid(self) -> Simplifiable | None:
        surface, _ = weld(self._facets.points, self._facets.corners)
        if not len(surface.triangles):
            return None
        return Simplifiable.of(surface, np.zeros(len(surface.triangles), dtype=np.int64))

    def simpler(self, tolerance: float) -> Facets:
        """Returns the simplified mesh, whose surface is moved by about `tolerance` [m] at most."""
        if tolerance not in self._by_tolerance:
            self._by_tolerance[tolerance] = self._simplified(tolerance)
        return self._by_tolerance[tolerance]

    def _simplified(self, tolerance: float) -> Facets:
        facets = self._facets
        if len(facets.corners) <= _MIN_TRIANGLES or tolerance <= 0.0 or self._solid is None:
            return facets
        simplified = self._solid.simplified(tolerance)
        if simplified is None:
            return clustered(facets, tolerance)
        surface, _ = simplified
        if len(surface.triangles) >= len(facets.corners):
            return facets
        return Facets(surface.vertices, surface.triangles, facets.of_faces)


def clustered(facets: Facets, tolerance: float) -> Facets:
    """Merges the points of a mesh in each cell of a grid to their mean; `tolerance` [m]: the diagonal of a
    cell."""
    if len(facets.corners) <= _MIN_TRIANGLES or tolerance <= 0.0:
        return facets
    cells = np.floor((facets.points - facets.points.min(axis=0)) * np.sqrt(3.0) / tolerance).astype(np.int64)
    means, index = cell_means(facets.points, cells)
    corners: Corners = index[facets.corners]
    has_area = (np.roll(corners, 1, axis=1) != corners).all(axis=1)
    return Facets(means, _without_duplicates(corners[has_area]), facets.of_faces)


def _without_duplicates(corners: Corners) -> Corners:
    """Removes duplicate triangles, whatever their first corner and their orientation."""
    _, first = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    return corners[np.sort(first)]


def _total(meshes: Mapping[Key, Facets], uses: Mapping[Key, int]) -> int:
    """Returns the number of triangles, counting each of the `uses` of a mesh."""
    return sum(len(facets.corners) * uses[key] for key, facets in meshes.items())


def _restored(
    simpler: dict[Key, Facets], finer: Mapping[Key, Facets], uses: Mapping[Key, int], max_triangles: int
) -> dict[Key, Facets]:
    """Replaces meshes by those of the level `finer`, the largest first, if the total then stays within
    `max_triangles`."""
    spare = max_triangles - _total(simpler, uses)
    for key in sorted(simpler, key=lambda name: -finer[name].size):
        additional = (len(finer[key].corners) - len(simpler[key].corners)) * uses[key]
        if additional <= spare:
            simpler[key] = finer[key]
            spare -= additional
    return simpler


def _emptied(meshes: dict[Key, Facets], uses: Mapping[Key, int], max_triangles: int) -> dict[Key, Facets]:
    """Removes all triangles of the smallest meshes until the total is within `max_triangles`."""
    nothing = np.empty((0, 3), dtype=np.int64)
    for key in sorted(meshes, key=lambda name: meshes[name].size):
        if _total(meshes, uses) <= max_triangles:
            break
        meshes[key] = Facets(meshes[key].points, nothing, meshes[key].of_faces)
    return meshes
