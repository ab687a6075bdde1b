"""Meshes with fewer triangles, for a page that opens and turns quickly.

All meshes of a robot have one tolerance, since they are seen from one distance: triangles stay where the
shape needs them, and small parts lose theirs first. manifold3d simplifies within the tolerance; what it does
not take, or hardly simplifies, is clustered: the points of each cell of a grid become one.
"""

from collections.abc import Hashable, Mapping
from typing import TypeVar

import numpy as np

from pipeline.live.triangles import Corners, Facets, Points
from stages.mesh.surface import weld
from stages.mesh.tessellation import PartMesh
from stages.mesh.visuals.simplify import simplified

_FIRST = 2e-5
_COARSE = 2e-2
_LAST = 5e-2
"""The finest and the coarsest tolerance, as shares of the size of the largest mesh; each level has twice the
one before. From `_COARSE` on meshes are clustered that have too many triangles still."""

_SAMPLE = 8
"""Of so many meshes the first tolerance is estimated."""

_LEAST = 12
"""Meshes with so few triangles stay as they are."""

_GREY = (0.5, 0.5, 0.5, 1.0)

Key = TypeVar("Key", bound=Hashable)


def fitted(meshes: Mapping[Key, Facets], uses: Mapping[Key, int], most: int) -> dict[Key, Facets]:
    """The meshes with at most `most` triangles together, counting each of their `uses`. Where no tolerance
    does it, the smallest meshes get none at all."""
    found = dict(meshes)
    if _total(found, uses) <= most:
        return found
    size = max(one.size for one in found.values())
    for way, first in ((simpler, _start(found, uses, most, size)), (clustered, _COARSE)):
        share = first
        while share <= _LAST:
            before = found
            found = {key: way(one, share * size) for key, one in before.items()}
            if _total(found, uses) <= most:
                return _restored(found, before, uses, most)
            share *= 2.0
    return _emptied(found, uses, most)


def _start(meshes: Mapping[Key, Facets], uses: Mapping[Key, int], most: int, size: float) -> float:
    """The tolerance to begin with, as a share: one level before the one that does it for a few of them."""
    every = sorted(meshes, key=lambda key: -len(meshes[key].corners))
    some = {key: meshes[key] for key in every[:: max(1, len(every) // _SAMPLE)]}
    enough = most * _total(some, uses) / _total(meshes, uses)
    share = _FIRST
    while len(some) < len(every) and share < _LAST:
        some = {key: simpler(one, share * size) for key, one in some.items()}
        if _total(some, uses) <= enough:
            return max(_FIRST, share / 2.0)
        share *= 2.0
    return _FIRST


def simpler(facets: Facets, tolerance: float) -> Facets:
    """The mesh with its surface moved by about `tolerance` [m] at most."""
    if len(facets.corners) <= _LEAST or tolerance <= 0.0:
        return facets
    surface, _ = weld(facets.points, facets.corners)
    if not len(surface.triangles):
        return facets
    palette = np.zeros(len(surface.triangles), dtype=np.int64)
    made = simplified(PartMesh(surface, (_GREY,), palette, False, 0.0), tolerance)
    if made is None:
        return clustered(facets, tolerance)
    if len(made.surface.triangles) >= len(facets.corners):
        return facets
    return Facets(made.surface.vertices, made.surface.triangles, facets.of_faces)


def clustered(facets: Facets, tolerance: float) -> Facets:
    """The mesh with the points of each cell of a grid in their middle; the tolerance is a cell's diagonal."""
    if len(facets.corners) <= _LEAST or tolerance <= 0.0:
        return facets
    cells = np.floor((facets.points - facets.points.min(axis=0)) * np.sqrt(3.0) / tolerance).astype(np.int64)
    _, place, counts = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    place = place.ravel()
    sums: Points = np.stack([np.bincount(place, facets.points[:, axis]) for axis in range(3)], axis=1)
    corners: Corners = place[facets.corners]
    whole = (np.roll(corners, 1, axis=1) != corners).all(axis=1)
    return Facets(sums / counts[:, None], _without_twins(corners[whole]), facets.of_faces)


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
