"""Points on surfaces, spread evenly by area, the same for the same surface."""

from dataclasses import dataclass

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure.tree import Corners, Indices

_FIRST, _SECOND = 0.7548776662466927, 0.5698402909980532
"""The steps of the R2 sequence: 1/p and 1/p² of the plastic number (Roberts, "The unreasonable effectiveness
of quasirandom sequences", 2018)."""


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Points (n, 3) and the triangle that each is on."""

    points: Points
    triangles: Indices


def even(corners: Corners, count: int) -> Samples:
    """`count` points on triangles (m, 3, 3), each standing for the same area: one in each stretch of the
    curve along the triangles, so that in the order of a `BoxTree` they are spread evenly in space too."""
    sizes = np.linalg.norm(_cross(corners), axis=1)
    total = np.cumsum(sizes)
    if not len(total) or total[-1] == 0.0:
        return Samples(np.zeros((0, 3)), np.zeros(0, dtype=np.int64))
    steps = np.arange(count)
    places = (steps + 0.5) / count * total[-1]
    which = np.minimum(np.searchsorted(total, places), len(total) - 1)
    u, v = (0.5 + steps * _FIRST) % 1, (0.5 + steps * _SECOND) % 1
    over = u + v > 1
    u, v = np.where(over, 1 - u, u)[:, None], np.where(over, 1 - v, v)[:, None]
    a, b, c = np.moveaxis(corners.take(which, axis=0), 1, 0)
    return Samples(a + (b - a) * u + (c - a) * v, which)


def thinned(surface: Surface, size: float) -> Points:
    """Vertices of the surface, one of those in each cube of a grid of that size [m]."""
    cells = np.floor((surface.vertices - surface.vertices.min(axis=0)) / size).astype(np.int64)
    _, first = np.unique(cells, axis=0, return_index=True)
    return surface.vertices[np.sort(first)]


def _cross(corners: Corners) -> Points:
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.cross(b - a, c - a)
