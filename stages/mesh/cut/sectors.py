"""Sectors of what is round: with a hole in its middle it is cut best by planes through its axis."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.cut.cutting import slicer

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
