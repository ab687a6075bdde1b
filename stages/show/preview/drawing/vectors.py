"""Computes with vectors (..., 3) component by component, several times as fast as reducing the axis."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def dot(first: Array, second: Array) -> Array:
    """Returns the scalar products (...)."""
    products: Array = first[..., 0] * second[..., 0]
    products += first[..., 1] * second[..., 1]
    products += first[..., 2] * second[..., 2]
    return products


def length(vectors: Array) -> Array:
    """Returns the lengths (...)."""
    return np.asarray(np.sqrt(dot(vectors, vectors)))


def unit(vectors: Array) -> Array:
    """Returns the vectors scaled to length 1; zero vectors stay zero."""
    lengths = length(vectors)
    lengths[lengths == 0] = 1
    return np.asarray(vectors / lengths[..., None])


def cross(first: Array, second: Array) -> Array:
    """Returns the vector products."""
    products = np.empty(np.broadcast_shapes(first.shape, second.shape), dtype=first.dtype)
    for axis, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        products[..., axis] = first[..., i] * second[..., j] - first[..., j] * second[..., i]
    return products


def mixed(shares: Array, corners: Array) -> Array:
    """Returns the points (n, k) of triangles (n, 3, k) with these shares (n, 3) of the corners (barycentric
    coordinates)."""
    points: Array = shares[:, 0, None] * corners[:, 0]
    points += shares[:, 1, None] * corners[:, 1]
    points += shares[:, 2, None] * corners[:, 2]
    return points
