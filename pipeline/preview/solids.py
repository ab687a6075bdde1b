"""Surfaces of MuJoCo's primitive shapes, as triangles with a normal at each corner."""

from dataclasses import dataclass

import numpy as np

from stages.mesh.view.raster import Corners, Numbers

_AROUND = 48
"""Sides of what is round."""

_RINGS = 12
"""Rings of a half ball."""


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """`corners` (m, 3, 3) of triangles [m], and the unit `normals` (m, 3, 3) there, pointing outwards."""

    corners: Corners
    normals: Corners


def ellipsoid(radii: Numbers) -> Skin:
    """About the origin; `radii` (3,) [m] along x, y and z."""
    circle = _half_circle()
    return _stretched(_turned((circle, circle)), radii)


def capsule(radius: float, half: float) -> Skin:
    """Along z; the cylinder between its half balls is 2 `half` long [m]."""
    circle = _half_circle()
    lower, upper = circle[: _RINGS + 1], circle[_RINGS:]
    points = np.concatenate([lower * radius - [0.0, half], upper * radius + [0.0, half]])
    return _turned((points, np.concatenate([lower, upper])))


def cylinder(radius: float, half: float) -> Skin:
    """Along z, 2 `half` long [m]."""
    points = [(0, -half), (radius, -half), (radius, -half), (radius, half), (radius, half), (0, half)]
    normals = [(0, -1), (0, -1), (1, 0), (1, 0), (0, 1), (0, 1)]
    return _turned((np.array(points, dtype=float), np.array(normals, dtype=float)))


def box(half: Numbers) -> Skin:
    """`half` (3,): half of its edges along x, y and z [m]."""
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]], dtype=float).reshape(2, 3, 2)
    corners, normals = [], []
    for axis in range(3):
        for side in (1.0, -1.0):
            face = np.full((2, 3, 3), side)
            face[:, :, (axis + 1) % 3], face[:, :, (axis + 2) % 3] = square[:, :, 0] * side, square[:, :, 1]
            corners.append(face * half)
            normals.append(np.broadcast_to(np.eye(3)[axis] * side, (2, 3, 3)))
    return Skin(np.concatenate(corners), np.concatenate(normals))


def _half_circle() -> Numbers:
    """(n, 2): points (radius, z) from pole to pole, the equator one of them, which are their own normals."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 2 * _RINGS + 1)
    points = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points[[0, -1]] = [[0.0, -1.0], [0.0, 1.0]]
    points[_RINGS] = [1.0, 0.0]
    return points


def _turned(profile: tuple[Numbers, Numbers]) -> Skin:
    """The surface of a profile of (radius, z) points and normals, turned about z."""
    turns = np.linspace(0, 2 * np.pi, _AROUND + 1)
    turns[-1] = 0.0
    swept = []
    for values in profile:
        x, y = (values[:, None, 0] * turn(turns)[None] for turn in (np.cos, np.sin))
        swept.append(np.stack([x, y, np.broadcast_to(values[:, None, 1], x.shape)], axis=2))
    corners, normals = (_triangles(grid) for grid in swept)
    edges = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    real = (edges * edges).sum(axis=1) > 0
    return Skin(corners[real], normals[real])


def _triangles(grid: Numbers) -> Corners:
    """Two triangles of each cell of a grid (rows, columns, 3) of points."""
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    both = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)], axis=2)
    return both.reshape(-1, 3, 3)


def _stretched(solid: Skin, factors: Numbers) -> Skin:
    normals = solid.normals / factors
    return Skin(solid.corners * factors, normals / np.linalg.norm(normals, axis=2, keepdims=True))
