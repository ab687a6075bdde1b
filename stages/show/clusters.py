"""Merges the points in each cell of a grid."""

from typing import Any

import numpy as np
import numpy.typing as npt


def cell_means(
    points: npt.NDArray[np.floating[Any]], cells: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.intp]]:
    """Returns the means (k, 3) of the points (n, 3) in each cell, and for each point (n,) the index of its
    mean.

    `cells` (n, 3): the cell of each point, numbered from 0 along each axis.
    """
    shape = cells.max(axis=0) + 1
    keys = (cells[:, 0] * shape[1] + cells[:, 1]) * shape[2] + cells[:, 2]
    _, mean_indices, count = np.unique(keys, return_inverse=True, return_counts=True)
    mean_indices = mean_indices.reshape(-1)
    means = np.stack([np.bincount(mean_indices, points[:, axis]) / count for axis in range(3)], axis=1)
    return means, mean_indices
