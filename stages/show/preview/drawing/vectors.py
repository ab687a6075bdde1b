"""Vectors (..., 3), many at once, a component at a time: to reduce an axis of three takes several times as
long."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def dot(one: Array, other: Array) -> Array:
    """(...): the scalar products."""
    found: Array = one[..., 0] * other[..., 0]
    found += one[..., 1] * other[..., 1]
    found += one[..., 2] * other[..., 2]
    return found


def length(vectors: Array) -> Array:
    """(...)."""
    return np.asarray(np.sqrt(dot(vectors, vectors)))


def unit(vectors: Array) -> Array:
    """The vectors, 1 long; those without length stay."""
    lengths = length(vectors)
    lengths[lengths == 0] = 1
    return np.asarray(vectors / lengths[..., None])


def cross(one: Array, other: Array) -> Array:
    """The vector products."""
    found = np.empty(np.broadcast_shapes(one.shape, other.shape), dtype=one.dtype)
    for axis, (first, second) in enumerate(((1, 2), (2, 0), (0, 1))):
        found[..., axis] = one[..., first] * other[..., second] - one[..., second] * other[..., first]
    return found


def mixed(shares: Array, corners: Array) -> Array:
    """(n, k): of triangles (n, 3, k) the points with these shares (n, 3) of the corners."""
    found: Array = shares[:, 0, None] * corners[:, 0]
    found += shares[:, 1, None] * corners[:, 1]
    found += shares[:, 2, None] * corners[:, 2]
    return found
