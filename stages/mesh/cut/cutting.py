"""Cuts surfaces, closed or not, by planes; the convex hull of each side becomes a piece of a collider.

A round part with a hole in its middle is best cut into sectors, by planes through its axis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface, drop_unused_points
from linkwright.stages.mesh.surfaces.booleans import body_of, surface_of_body

Indices = npt.NDArray[np.int64]

P = TypeVar("P")
"""Type of the pieces that `cut_costliest` cuts."""


def make_slicer(surface: Surface) -> Callable[[Points, float], list[Surface]]:
    """Returns a function that cuts the surface by a plane, given its unit normal (3,) and its height [m]
    along the normal, and returns the sides that are not empty.

    The sides of a closed surface are closed, so that pieces leave no gap where planes meet inside a solid.
    """
    body = body_of(surface)
    if body is None:
        return lambda normal, height: [
            side for side in cut_by_plane(surface, normal, height) if len(side.triangles)
        ]
    return lambda normal, height: [
        surface_of_body(side) for side in body.split_by_plane(normal, height) if not side.is_empty()
    ]


def cut_costliest(
    pieces: Sequence[P], costs: Callable[[list[P]], Sequence[float]], halve: Callable[[P], list[P]]
) -> Iterator[list[P]]:
    """Yields all pieces, first as they are, then after each cut. Ends when no piece with a cost above 0 can
    be halved. Each cut halves the costliest of the pieces that can be halved, and puts the halves in its
    place.

    `costs`: returns the cost of each piece; `halve`: returns the halves of a piece, or an empty list.
    """
    current = [*pieces]
    while True:
        yield current
        piece_costs = costs(current)
        # Of equally costly pieces, the first is cut.
        for index in sorted(range(len(current)), key=lambda index: (-piece_costs[index], index)):
            if halves := halve(current[index]) if piece_costs[index] > 0 else []:
                current = [*current[:index], *halves, *current[index + 1 :]]
                break
        else:
            return


def cut_by_plane(surface: Surface, normal: Points, height: float) -> tuple[Surface, Surface]:
    """Returns the two sides of a surface: the side where normal·x ≤ `height` [m], and the other side. Both
    stay open at the plane. `normal`: unit vector (3,)."""
    points, triangles = surface.vertices, surface.triangles
    heights = points @ normal - height
    is_high = (heights > 0)[triangles]
    high_count = is_high.sum(axis=1)
    low_triangles = [triangles[high_count == 0]]
    high_triangles = [triangles[high_count == 3]]
    vertices = points
    for lone_is_high, lone_side, pair_side in (
        (True, high_triangles, low_triangles),
        (False, low_triangles, high_triangles),
    ):
        rows = np.flatnonzero(high_count == (1 if lone_is_high else 2))
        lone_corners = (is_high[rows] == lone_is_high).argmax(axis=1)
        # Corners in cyclic order from the lone one, so that the new triangles face as the old one does.
        order = (lone_corners[:, None] + np.arange(3)) % 3
        lone, first, second = np.take_along_axis(triangles[rows], order, axis=1).T
        new_points = [_points_at_plane(points, heights, lone, end) for end in (first, second)]
        to_first, to_second = len(vertices) + np.arange(2 * len(rows)).reshape(2, -1)
        vertices = np.concatenate([vertices, *new_points])
        # The plane cuts off the lone corner, as a triangle; the other two corners keep a quadrilateral, which
        # becomes two triangles.
        lone_side.append(np.column_stack([lone, to_first, to_second]))
        pair_side.append(np.column_stack([to_first, first, second]))
        pair_side.append(np.column_stack([to_first, second, to_second]))
    low_side, high_side = (
        drop_unused_points(Surface(vertices, np.concatenate(side)))
        for side in (low_triangles, high_triangles)
    )
    return low_side, high_side


def _points_at_plane(points: Points, heights: Points, starts: Indices, ends: Indices) -> Points:
    """Returns the points (m, 3) at which edges cross a plane. `points`: (n, 3); `heights`: their heights
    above the plane (n,) [m]; `starts`, `ends`: indices of the points of each edge (m,)."""
    # The height is 0 at this share of the way from the start of an edge to its end.
    shares = heights[starts] / (heights[starts] - heights[ends])
    crossings: Points = points[starts] + shares[:, None] * (points[ends] - points[starts])
    return crossings


_PLANE_COUNTS = (4, 8)
"""Numbers of planes through the axis; each plane adds two sectors."""

_MAX_AREA_DIFFERENCE = 0.25
"""Largest difference between the areas of a round part's sectors, as a share of the largest area."""


def cut_into_sectors(surface: Surface) -> Iterator[list[Surface]]:
    """Yields a round surface in 8 sectors, then in 16; yields nothing for other surfaces.

    A surface is round if its 8 sectors around x, y or z, through the middle of its box, have similar areas.
    """
    differences = []
    for axis in range(3):
        areas = [sector.area() for sector in _sectors(surface, axis, _PLANE_COUNTS[0])]
        # A sector without surface counts as the largest difference.
        is_complete = len(areas) == 2 * _PLANE_COUNTS[0]
        differences.append(round(1 - min(areas) / max(areas), 3) if is_complete else 1.0)
    least = min(differences)
    if least <= _MAX_AREA_DIFFERENCE:
        for plane_count in _PLANE_COUNTS:
            yield _sectors(surface, differences.index(least), plane_count)


def _sectors(surface: Surface, axis: int, plane_count: int) -> list[Surface]:
    """Cuts a surface by planes at equal angles. The planes contain the line along `axis` (0, 1, 2: x, y, z)
    through the centre of the surface's box."""
    centre = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
    first_axis, second_axis = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
    sectors = [surface]
    for angle in np.pi * np.arange(plane_count) / plane_count:
        normal = np.cos(angle) * first_axis + np.sin(angle) * second_axis
        height = float(normal @ centre)
        sectors = [side for sector in sectors for side in make_slicer(sector)(normal, height)]
    return sectors
