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


def fitted(meshes: Mapping[Key, Facets], uses: Mapping[Key, int], most: int) -> dict[Key, Facets]:
    """Simplifies the meshes until they have at most `most` triangles together, counting each of their `uses`.
    If no tolerance is enough, the smallest meshes lose all triangles."""
    simpler = dict(meshes)
    if _total(simpler, uses) <= most:
        return simpler
    size = max(facets.size for facets in simpler.values())
    solids = {key: Thinnable(facets) for key, facets in simpler.items()}

    def at(level: int) -> dict[Key, Facets]:
        return {key: solid.simpler(_MIN_TOLERANCE * 2.0**level * size) for key, solid in solids.items()}

    last = int(np.log2(_MAX_TOLERANCE / _MIN_TOLERANCE))
    is_near = _total(simpler, uses) <= _MAX_FINE_EXCESS * most
    # Only the coarsest level shows whether any level is enough. It takes longest, so it is not tried first if
    # little must be lost.
    if is_near or _total(at(last), uses) <= most:
        level = lowest_level(
            last + 1, lambda number: _total(at(number), uses), most, last // 4 if is_near else None
        )
        if level <= last:
            return _restored(at(level), at(level - 1) if level else simpler, uses, most)
    simpler, share = at(last), _CLUSTER_TOLERANCE
    while share <= _MAX_TOLERANCE:
        before = simpler
        simpler = {key: clustered(facets, share * size) for key, facets in before.items()}
        if _total(simpler, uses) <= most:
            return _restored(simpler, before, uses, most)
        share *= 2.0
    return _emptied(simpler, uses, most)


class Thinnable:
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
    simpler: dict[Key, Facets], before: Mapping[Key, Facets], uses: Mapping[Key, int], most: int
) -> dict[Key, Facets]:
    """Replaces meshes by those of the finer level `before`, the largest first, if the total then stays within
    `most`."""
    left = most - _total(simpler, uses)
    for key in sorted(simpler, key=lambda name: -before[name].size):
        additional = (len(before[key].corners) - len(simpler[key].corners)) * uses[key]
        if additional <= left:
            simpler[key] = before[key]
            left -= additional
    return simpler


def _emptied(meshes: dict[Key, Facets], uses: Mapping[Key, int], most: int) -> dict[Key, Facets]:
    """Removes all triangles of the smallest meshes until the total is within `most`."""
    nothing = np.empty((0, 3), dtype=np.int64)
    for key in sorted(meshes, key=lambda name: meshes[name].size):
        if _total(meshes, uses) <= most:
            break
        meshes[key] = Facets(meshes[key].points, nothing, meshes[key].of_faces)
    return meshes
