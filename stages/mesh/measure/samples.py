"""Spreads points over surfaces evenly by area, in the same way whenever the surface is the same."""

from dataclasses import dataclass

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure.tree import Corners, Indices

_FIRST_STEP, _SECOND_STEP = 0.7548776662466927, 0.5698402909980532
"""Steps of the R2 sequence: 1/p and 1/p² with the plastic number p (Roberts, "The unreasonable effectiveness
of quasirandom sequences", 2018)."""


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Points (n, 3), and the index of the triangle that each lies on."""

    points: Points
    triangles: Indices


def evenly_spread(corners: Corners, count: int) -> Samples:
    """Returns `count` points on triangles (m, 3, 3). Each point represents an equal share of the area, taken
    along the order of the triangles, so that in the order of a `BoxTree` they are spread evenly in space
    too."""
    sizes = np.linalg.norm(_cross(corners), axis=1)
    total = np.cumsum(sizes)
    if not len(total) or total[-1] == 0.0:
        return Samples(np.zeros((0, 3)), np.zeros(0, dtype=np.int64))
    steps = np.arange(count)
    positions = (steps + 0.5) / count * total[-1]
    triangle_indices = np.minimum(np.searchsorted(total, positions), len(total) - 1)
    u, v = (0.5 + steps * _FIRST_STEP) % 1, (0.5 + steps * _SECOND_STEP) % 1
    beyond_diagonal = u + v > 1
    u, v = np.where(beyond_diagonal, 1 - u, u)[:, None], np.where(beyond_diagonal, 1 - v, v)[:, None]
    a, b, c = np.moveaxis(corners.take(triangle_indices, axis=0), 1, 0)
    return Samples(a + (b - a) * u + (c - a) * v, triangle_indices)


def one_per_cell(surface: Surface, size: float) -> Points:
    """Returns one of the surface's vertices in each cube of a grid with cubes of the given size [m]."""
    cells = np.floor((surface.vertices - surface.vertices.min(axis=0)) / size).astype(np.int64)
    _, first = np.unique(cells, axis=0, return_index=True)
    return surface.vertices[np.sort(first)]


def _cross(corners: Corners) -> Points:
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.cross(b - a, c - a)
