"""Makes the surfaces of MuJoCo's primitive shapes, as triangles (m, 3, 3) [m]."""

import numpy as np

from linkwright.stages.show.raster import Corners, Numbers

_SIDES = 48
"""Number of sides of round shapes."""

_RINGS = 12
"""Number of rings of a half ball."""


def ellipsoid(radii: Numbers) -> Corners:
    """Returns an ellipsoid about the origin; `radii` (3,) [m] along x, y and z."""
    return _surface_of_revolution(_half_circle()) * radii


def capsule(radius: float, half: float) -> Corners:
    """Returns a capsule along z; the cylinder between its half balls is 2 `half` long [m]."""
    circle = _half_circle() * radius
    shift = np.array([0.0, half])
    return _surface_of_revolution(np.concatenate([circle[: _RINGS + 1] - shift, circle[_RINGS:] + shift]))


def cylinder(radius: float, half: float) -> Corners:
    """Returns a cylinder along z, 2 `half` long [m]."""
    return _surface_of_revolution(np.array([(0.0, -half), (radius, -half), (radius, half), (0.0, half)]))


def box(half: Numbers) -> Corners:
    """Returns a box; `half` (3,): half of its edges along x, y and z [m]."""
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]], dtype=float).reshape(2, 3, 2)
    faces = []
    for axis in range(3):
        for side in (1.0, -1.0):
            face = np.full((2, 3, 3), side)
            face[:, :, (axis + 1) % 3], face[:, :, (axis + 2) % 3] = square[:, :, 0] * side, square[:, :, 1]
            faces.append(face * half)
    return np.concatenate(faces)


def _half_circle() -> Numbers:
    """Returns points (n, 2) (radius, z) of a ball of radius 1 from pole to pole, including the equator."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 2 * _RINGS + 1)
    points = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points[[0, -1]] = [[0.0, -1.0], [0.0, 1.0]]
    points[_RINGS] = [1.0, 0.0]
    return points


def _surface_of_revolution(profile: Numbers) -> Corners:
    """Returns the surface that a profile of (radius, z) points forms when it is turned about z."""
    turns = np.linspace(0, 2 * np.pi, _SIDES + 1)
    turns[-1] = 0.0
    x, y = (profile[:, None, 0] * function(turns)[None] for function in (np.cos, np.sin))
    corners = _triangles(np.stack([x, y, np.broadcast_to(profile[:, None, 1], x.shape)], axis=2))
    edges = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces: Corners = corners[(edges * edges).sum(axis=1) > 0]
    return faces


def _triangles(grid: Numbers) -> Corners:
    """Returns two triangles for each cell of a grid (rows, columns, 3) of points."""
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    faces = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)], axis=2)
    return faces.reshape(-1, 3, 3)
