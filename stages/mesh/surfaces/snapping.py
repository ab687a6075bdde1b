"""Moves coordinates to a grid, so that hashes and files do not depend on how a processor rounds."""

import math

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface, weld

_PITCH_SHARE = 1e-6


def grid(size: float) -> float:
    """Returns the pitch [m] of the grid of a surface with a diagonal of `size` [m]: a power of two, about a
    millionth of the size, so that the last digit of the size does not matter."""
    return math.ldexp(1.0, round(math.log2(size * _PITCH_SHARE))) if size > 0 else 0.0


def on_grid(points: Points, pitch: float) -> Points:
    """Returns the points (n, 3), each moved to the nearest node of the grid; + 0.0 makes -0.0 equal to
    0.0."""
    return np.rint(points / pitch) * pitch + 0.0 if pitch > 0 else points + 0.0


def snapped(surface: Surface) -> Surface:
    """Returns the surface with its vertices on the grid of its size, welded, in canonical order."""
    size = surface.diagonal if len(surface.vertices) else 0.0
    welded, _ = weld(on_grid(surface.vertices, grid(size)), surface.triangles)
    return welded
