"""Cuts surfaces, closed or not, by planes; the convex hull of each side becomes a piece of a collider.

A round part with a hole in its middle is best cut into sectors, by planes through its axis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface, compacted
from linkwright.stages.mesh.surfaces.booleans import body_of, surface_of_body

P = TypeVar("P")


def slicer(surface: Surface) -> Callable[[Points, float], list[Surface]]:
    """Returns a function that cuts a surface by a plane, normal·x = height, and returns the sides that are
    not empty. The sides of a closed surface are closed, so that pieces leave no gap where planes meet inside
    a solid."""
    body = body_of(surface)
    if body is None:
        return lambda normal, height: [side for side in cut(surface, normal, height) if len(side.triangles)]
    return lambda normal, height: [
        surface_of_body(side) for side in body.split_by_plane(normal, height) if not side.is_empty()
    ]


def cuts(
    pieces: Sequence[P], costs: Callable[[list[P]], Sequence[float]], halves: Callable[[P], list[P]]
) -> Iterator[list[P]]:
    """Yields the pieces; then again and again the pieces after the costliest that can be halved was
    halved."""
    current = [*pieces]
    while True:
        yield current
        ratings = costs(current)
        for number in sorted(range(len(current)), key=lambda number: (-ratings[number], number)):
            if parts := halves(current[number]) if ratings[number] > 0 else []:
                current = [*current[:number], *parts, *current[number + 1 :]]
                break
        else:
            return


def cut(surface: Surface, normal: Points, height: float) -> tuple[Surface, Surface]:
    """Returns the two sides of a surface: where normal·x ≤ height, and the rest; normal (3,)."""
    points, triangles = surface.vertices, surface.triangles
    above = points @ normal - height
    high = (above > 0)[triangles]
    count = high.sum(axis=1)
    vertices, below, over = [points], [triangles[count == 0]], [triangles[count == 3]]
    vertex_count = len(points)
    for number, single_side, pair_side in ((1, over, below), (2, below, over)):
        rows = np.flatnonzero(count == number)
        corner = (high[rows] if number == 1 else ~high[rows]).argmax(axis=1)
        order = (corner[:, None] + np.arange(3)) % 3
        lone, first, second = np.take_along_axis(triangles[rows], order, axis=1).T
        for end in (first, second):
            share = above[lone] / (above[lone] - above[end])
            vertices.append(points[lone] + share[:, None] * (points[end] - points[lone]))
        to_first, to_second = vertex_count + np.arange(2 * len(rows)).reshape(2, -1)
        vertex_count += 2 * len(rows)
        single_side.append(np.column_stack([lone, to_first, to_second]))
        pair_side.append(np.column_stack([to_first, first, second]))
        pair_side.append(np.column_stack([to_first, second, to_second]))
    all_vertices = np.concatenate(vertices)
    low_side, high_side = (compacted(Surface(all_vertices, np.concatenate(side))) for side in (below, over))
    return low_side, high_side


_PLANE_COUNTS = (4, 8)
"""Numbers of planes through the axis, which give twice as many sectors."""

_MAX_AREA_DIFFERENCE = 0.25
"""Largest difference between the areas of a round part's sectors, as a share of the largest area."""


def in_sectors(surface: Surface) -> Iterator[list[Surface]]:
    """Yields a round surface in 8 sectors, then in 16; yields nothing for other surfaces. A surface is round
    if its sectors around an axis have similar areas."""
    differences = []
    for axis in range(3):
        areas = [sector.area() for sector in _sectors(surface, axis, _PLANE_COUNTS[0])]
        differences.append(
            round(1 - min(areas) / max(areas), 3) if len(areas) == 2 * _PLANE_COUNTS[0] else 1.0
        )
    if min(differences) <= _MAX_AREA_DIFFERENCE:
        for count in _PLANE_COUNTS:
            yield _sectors(surface, differences.index(min(differences)), count)


def _sectors(surface: Surface, axis: int, count: int) -> list[Surface]:
    """Cuts a surface by `count` planes that contain the line along an axis through the centre of its box."""
    middle = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
    first, second = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
    sectors = [surface]
    for turn in np.pi * np.arange(count) / count:
        normal = np.cos(turn) * first + np.sin(turn) * second
        sectors = [side for part in sectors for side in slicer(part)(normal, float(normal @ middle))]
    return sectors
