"""Coordinates on a grid: what is hashed or written does not show how a processor rounds."""

import math

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface, weld

_OF_SIZE = 1e-6


def grid(size: float) -> float:
    """The pitch [m] of the grid of a surface that is `size` [m] across: a power of two, about a millionth of
    it, so that the last digit of the size does not matter."""
    return math.ldexp(1.0, round(math.log2(size * _OF_SIZE))) if size > 0 else 0.0


def on_grid(points: Points, pitch: float) -> Points:
    """The points (n, 3), each moved to the nearest place of the grid."""
    return np.rint(points / pitch) * pitch + 0.0 if pitch > 0 else points + 0.0


def snapped(surface: Surface) -> Surface:
    """The surface with its vertices on the grid of its size, welded, in canonical order."""
    size = surface.diagonal if len(surface.vertices) else 0.0
    welded, _ = weld(on_grid(surface.vertices, grid(size)), surface.triangles)
    return welded
