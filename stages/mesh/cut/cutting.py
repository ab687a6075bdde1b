"""A surface, closed or not, cut by a plane; each side's convex hull is a piece of a collider.

What is round, with a hole in its middle, is cut best by planes through its axis, into sectors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface, compacted
from linkwright.stages.mesh.surfaces.booleans import body_of, surface_of_body

P = TypeVar("P")


def slicer(surface: Surface) -> Callable[[Points, float], list[Surface]]:
    """Cuts a surface by a plane, normal·x = height, into what is on either side, as far as there is anything.
    What is closed stays so: where later planes meet inside of a solid, that belongs to a piece."""
    body = body_of(surface)
    if body is None:
        return lambda normal, height: [side for side in cut(surface, normal, height) if len(side.triangles)]
    return lambda normal, height: [
        surface_of_body(side) for side in body.split_by_plane(normal, height) if not side.is_empty()
    ]


def cuts(
    pieces: Sequence[P], costs: Callable[[list[P]], Sequence[float]], halves: Callable[[P], list[P]]
) -> Iterator[list[P]]:
    """The pieces, and then, again and again, those with the costliest in halves that has any."""
    now = [*pieces]
    while True:
        yield now
        rated = costs(now)
        for number in sorted(range(len(now)), key=lambda number: (-rated[number], number)):
            if made := halves(now[number]) if rated[number] > 0 else []:
                now = [*now[:number], *made, *now[number + 1 :]]
                break
        else:
            return


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


_PLANES = (4, 8)
"""Through the axis: 8 and 16 sectors."""

_ALIKE = 0.25
"""By what share of the largest the areas of the sectors of such a part differ at most."""


def in_sectors(surface: Surface) -> Iterator[list[Surface]]:
    """A surface that is much the same on all sides of an axis, as with a hole in its middle it is, in 8
    sectors and in 16; nothing of any other."""
    spreads = []
    for axis in range(3):
        areas = [sector.area() for sector in _sectors(surface, axis, _PLANES[0])]
        spreads.append(round(1 - min(areas) / max(areas), 3) if len(areas) == 2 * _PLANES[0] else 1.0)
    if min(spreads) <= _ALIKE:
        for count in _PLANES:
            yield _sectors(surface, spreads.index(min(spreads)), count)


def _sectors(surface: Surface, axis: int, count: int) -> list[Surface]:
    """A surface cut by so many planes through the middle of its box along an axis."""
    middle = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
    first, second = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
    found = [surface]
    for turn in np.pi * np.arange(count) / count:
        normal = np.cos(turn) * first + np.sin(turn) * second
        found = [side for part in found for side in slicer(part)(normal, float(normal @ middle))]
    return found
