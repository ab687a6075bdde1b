"""Computes with vectors (..., 3) by component: several times as fast as along the last axis."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def dot(first: Array, second: Array) -> Array:
    """Returns the scalar products (...) of vectors (..., 3)."""
    products: Array = first[..., 0] * second[..., 0]
    products += first[..., 1] * second[..., 1]
    products += first[..., 2] * second[..., 2]
    return products


def lengths_of(vectors: Array) -> Array:
    """Returns the lengths (...) of vectors (..., 3)."""
    return np.asarray(np.sqrt(dot(vectors, vectors)))


def unit_vectors(vectors: Array) -> Array:
    """Returns the vectors (..., 3) scaled to length 1; zero vectors stay zero."""
    lengths = lengths_of(vectors)
    lengths[lengths == 0] = 1
    return np.asarray(vectors / lengths[..., None])


def cross(first: Array, second: Array) -> Array:
    """Returns the vector products (..., 3) of vectors (..., 3), in the type of the first."""
    products = np.empty(np.broadcast_shapes(first.shape, second.shape), dtype=first.dtype)
    for axis, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        products[..., axis] = first[..., i] * second[..., j] - first[..., j] * second[..., i]
    return products


def interpolate(weights: Array, corner_values: Array) -> Array:
    """Returns a point or vector (n, k) in each of n triangles: the sum of its `corner_values`
    (n, 3, k) times their weights (n, 3), which are barycentric coordinates."""
    values: Array = weights[:, 0, None] * corner_values[:, 0]
    values += weights[:, 1, None] * corner_values[:, 1]
    values += weights[:, 2, None] * corner_values[:, 2]
    return values
