"""Rigid transforms as (4, 4) arrays. Metres and radians.

What ends up in replies is computed with elementwise operations only: BLAS and vectorised sines
differ in the last bit between processors, and the shipped sample must not.
"""

import math

import numpy as np


def frame(xyz=(0.0, 0.0, 0.0), x=None, z=None):
    """A frame at `xyz` with the given x and z axes (unit vectors; by default the world's own)."""
    made = np.eye(4)
    made[:3, 3] = xyz
    if x is not None or z is not None:
        z = np.array([0.0, 0.0, 1.0] if z is None else z, float)
        x = np.array([1.0, 0.0, 0.0] if x is None else x, float)
        made[:3, :3] = np.column_stack([x, np.cross(z, x), z]) + 0.0
    return made


def turn(axis, angle, xyz=(0.0, 0.0, 0.0)):
    """A rotation by `angle` about a unit `axis`, and then the translation `xyz` (Rodrigues)."""
    x, y, z = (float(part) for part in axis)
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    made = np.eye(4)
    made[:3, :3] += math.sin(angle) * skew + 2 * math.sin(angle / 2) ** 2 * product(skew, skew)
    made[:3, 3] = xyz
    return made


def product(*matrices):
    """The matrix product, from left to right, the same on every processor."""
    total = matrices[0]
    for matrix in matrices[1:]:
        terms = total[:, :, None] * matrix[None]
        total = terms[:, 0]
        for k in range(1, terms.shape[1]):
            total = total + terms[:, k]
    return total


def inverse(a_from_b):
    """b_from_a."""
    made = np.eye(4)
    made[:3, :3] = a_from_b[:3, :3].T
    made[:3, 3] = -product(made[:3, :3], a_from_b[:3, 3:])[:, 0]
    return made + 0.0


def rotation_vector(rotation):
    """The rotation vector [rad] (3,) of a (3, 3) rotation less than half a turn."""
    part = np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    sine, cosine = np.linalg.norm(part) / 2, (np.trace(rotation) - 1) / 2
    return part / 2 * (1.0 if sine < 1e-9 else np.arctan2(sine, cosine) / sine)
