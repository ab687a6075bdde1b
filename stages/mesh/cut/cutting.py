"""A surface, closed or not, cut by a plane; each side's convex hull is a piece of a collider."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface, compacted
from linkwright.stages.mesh.surfaces.booleans import body_of, surface_of_body


def slicer(surface: Surface) -> Callable[[Points, float], list[Surface]]:
    """Cuts a surface by a plane, normal·x = height, into what is on either side, as far as there is anything.
    What is closed stays so: where later planes meet inside of a solid, that belongs to a piece."""
    body = body_of(surface)
    if body is None:
        return lambda normal, height: [side for side in cut(surface, normal, height) if len(side.triangles)]
    return lambda normal, height: [
        surface_of_body(side) for side in body.split_by_plane(normal, height) if not side.is_empty()
    ]


def cut(surface: Surface, normal: Points, height: float) -> tuple[Surface, Surface]:
    """What is on the side where normal·x ≤ height, and what is on the other; normal (3,)."""
    points, triangles = surface.vertices, surface.triangles
    above = points @ normal - height
    high = (above > 0)[triangles]
    count = high.sum(axis=1)
    vertices, below, over = [points], [triangles[count == 0]], [triangles[count == 3]]
    made = len(points)
    for number, alone_side, pair_side in ((1, over, below), (2, below, over)):
        rows = np.flatnonzero(count == number)
        corner = (high[rows] if number == 1 else ~high[rows]).argmax(axis=1)
        order = (corner[:, None] + np.arange(3)) % 3
        alone, first, second = np.take_along_axis(triangles[rows], order, axis=1).T
        for end in (first, second):
            share = above[alone] / (above[alone] - above[end])
            vertices.append(points[alone] + share[:, None] * (points[end] - points[alone]))
        to_first, to_second = made + np.arange(2 * len(rows)).reshape(2, -1)
        made += 2 * len(rows)
        alone_side.append(np.column_stack([alone, to_first, to_second]))
        pair_side.append(np.column_stack([to_first, first, second]))
        pair_side.append(np.column_stack([to_first, second, to_second]))
    every = np.concatenate(vertices)
    low_side, high_side = (compacted(Surface(every, np.concatenate(side))) for side in (below, over))
    return low_side, high_side
