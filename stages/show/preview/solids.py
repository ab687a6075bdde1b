"""Surfaces of MuJoCo's primitive shapes, as triangles (m, 3, 3) [m]."""

import numpy as np

from linkwright.stages.show.raster import Corners, Numbers

_AROUND = 48
"""Sides of what is round."""

_RINGS = 12
"""Rings of a half ball."""


def ellipsoid(radii: Numbers) -> Corners:
    """About the origin; `radii` (3,) [m] along x, y and z."""
    return _turned(_half_circle()) * radii


def capsule(radius: float, half: float) -> Corners:
    """Along z; the cylinder between its half balls is 2 `half` long [m]."""
    circle = _half_circle() * radius
    away = np.array([0.0, half])
    return _turned(np.concatenate([circle[: _RINGS + 1] - away, circle[_RINGS:] + away]))


def cylinder(radius: float, half: float) -> Corners:
    """Along z, 2 `half` long [m]."""
    return _turned(np.array([(0.0, -half), (radius, -half), (radius, half), (0.0, half)]))


def box(half: Numbers) -> Corners:
    """`half` (3,): half of its edges along x, y and z [m]."""
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]], dtype=float).reshape(2, 3, 2)
    faces = []
    for axis in range(3):
        for side in (1.0, -1.0):
            face = np.full((2, 3, 3), side)
            face[:, :, (axis + 1) % 3], face[:, :, (axis + 2) % 3] = square[:, :, 0] * side, square[:, :, 1]
            faces.append(face * half)
    return np.concatenate(faces)


def _half_circle() -> Numbers:
    """(n, 2): points (radius, z) of a ball of radius 1 from pole to pole, the equator one of them."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 2 * _RINGS + 1)
    points = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points[[0, -1]] = [[0.0, -1.0], [0.0, 1.0]]
    points[_RINGS] = [1.0, 0.0]
    return points


def _turned(profile: Numbers) -> Corners:
    """The surface of a profile of (radius, z) points, turned about z."""
    turns = np.linspace(0, 2 * np.pi, _AROUND + 1)
    turns[-1] = 0.0
    x, y = (profile[:, None, 0] * turn(turns)[None] for turn in (np.cos, np.sin))
    corners = _triangles(np.stack([x, y, np.broadcast_to(profile[:, None, 1], x.shape)], axis=2))
    edges = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    found: Corners = corners[(edges * edges).sum(axis=1) > 0]
    return found


def _triangles(grid: Numbers) -> Corners:
    """Two triangles of each cell of a grid (rows, columns, 3) of points."""
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    both = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)], axis=2)
    return both.reshape(-1, 3, 3)
