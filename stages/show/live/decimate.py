"""Meshes with fewer triangles, for a page that opens and turns quickly.

All meshes of a robot have one tolerance, since they are seen from one distance: triangles stay where the
shape needs them, and small parts lose theirs first. manifold3d simplifies within the tolerance; what it does
not take, or hardly simplifies, is clustered: the points of each cell of a grid become one.
"""

import functools
from collections.abc import Hashable, Mapping
from typing import TypeVar

import numpy as np

from linkwright.stages.formats.meshes.surface import weld
from linkwright.stages.show.clusters import cell_means
from linkwright.stages.show.decimate import Simplifiable, lowest
from linkwright.stages.show.live.triangles import Corners, Facets

_FIRST = 2e-5
_COARSE = 2e-2
_LAST = 5e-2
"""The finest and the coarsest tolerance, as shares of the size of the largest mesh; each level has twice the
one before. Where no level has few enough triangles, meshes are clustered from `_COARSE` on."""

_FEW = 2
"""Up to so many times too many triangles a fine level is likely to be enough."""

_LEAST = 12
"""Meshes with so few triangles stay as they are."""

Key = TypeVar("Key", bound=Hashable)


def fitted(meshes: Mapping[Key, Facets], uses: Mapping[Key, int], most: int) -> dict[Key, Facets]:
    """The meshes with at most `most` triangles together, counting each of their `uses`. Where no tolerance
    does it, the smallest meshes get none at all."""
    found = dict(meshes)
    if _total(found, uses) <= most:
        return found
    size = max(one.size for one in found.values())
    solids = {key: Thinnable(one) for key, one in found.items()}

    def at(level: int) -> dict[Key, Facets]:
        return {key: solid.simpler(_FIRST * 2.0**level * size) for key, solid in solids.items()}

    last = int(np.log2(_LAST / _FIRST))
    few = _total(found, uses) <= _FEW * most
    # Some meshes hardly lose triangles, which only the coarsest level shows at once; it takes longest.
    if few or _total(at(last), uses) <= most:
        level = lowest(last + 1, lambda number: _total(at(number), uses), most, last // 4 if few else None)
        if level <= last:
            return _restored(at(level), at(level - 1) if level else found, uses, most)
    found, share = at(last), _COARSE
    while share <= _LAST:
        before = found
        found = {key: clustered(one, share * size) for key, one in before.items()}
        if _total(found, uses) <= most:
            return _restored(found, before, uses, most)
        share *= 2.0
    return _emptied(found, uses, most)


class Thinnable:
    """A mesh, made ready once for all tolerances."""

    def __init__(self, facets: Facets) -> None:
        self._facets = facets
        self._made: dict[float, Facets] = {}

    @functools.cached_property
    def _solid(self) -> Simplifiable | None:
        surface, _ = weld(self._facets.points, self._facets.corners)
        if not len(surface.triangles):
            return None
        return Simplifiable.of(surface, np.zeros(len(surface.triangles), dtype=np.int64))

    def simpler(self, tolerance: float) -> Facets:
        """The mesh with its surface moved by about `tolerance` [m] at most."""
        if tolerance not in self._made:
            self._made[tolerance] = self._simplified(tolerance)
        return self._made[tolerance]

    def _simplified(self, tolerance: float) -> Facets:
        facets = self._facets
        if len(facets.corners) <= _LEAST or tolerance <= 0.0 or self._solid is None:
            return facets
        made = self._solid.simplified(tolerance)
        if made is None:
            return clustered(facets, tolerance)
        surface, _ = made
        if len(surface.triangles) >= len(facets.corners):
            return facets
        return Facets(surface.vertices, surface.triangles, facets.of_faces)


def clustered(facets: Facets, tolerance: float) -> Facets:
    """The mesh with the points of each cell of a grid in their middle; the tolerance is a cell's diagonal."""
    if len(facets.corners) <= _LEAST or tolerance <= 0.0:
        return facets
    cells = np.floor((facets.points - facets.points.min(axis=0)) * np.sqrt(3.0) / tolerance).astype(np.int64)
    means, place = cell_means(facets.points, cells)
    corners: Corners = place[facets.corners]
    whole = (np.roll(corners, 1, axis=1) != corners).all(axis=1)
    return Facets(means, _without_twins(corners[whole]), facets.of_faces)


def _without_twins(corners: Corners) -> Corners:
    """The triangles, each once whatever its first corner and its side."""
    _, first = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    return corners[np.sort(first)]


def _total(meshes: Mapping[Key, Facets], uses: Mapping[Key, int]) -> int:
    return sum(len(one.corners) * uses[key] for key, one in meshes.items())


def _restored(
    found: dict[Key, Facets], before: Mapping[Key, Facets], uses: Mapping[Key, int], most: int
) -> dict[Key, Facets]:
    """The meshes, the largest of them of the level before as far as there is room."""
    left = most - _total(found, uses)
    for key in sorted(found, key=lambda one: -before[one].size):
        more = (len(before[key].corners) - len(found[key].corners)) * uses[key]
        if more <= left:
            found[key] = before[key]
            left -= more
    return found


def _emptied(found: dict[Key, Facets], uses: Mapping[Key, int], most: int) -> dict[Key, Facets]:
    nothing = np.empty((0, 3), dtype=np.int64)
    for key in sorted(found, key=lambda one: found[one].size):
        if _total(found, uses) <= most:
            break
        found[key] = Facets(found[key].points, nothing, found[key].of_faces)
    return found
