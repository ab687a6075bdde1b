"""Points of one cell of a grid as one point."""

from typing import Any

import numpy as np
import numpy.typing as npt


def cell_means(
    points: npt.NDArray[np.floating[Any]], cells: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.intp]]:
    """The mean (k, 3) of the points (n, 3) in each cell, and the place (n,) of each point among them.

    `cells` (n, 3): the cell of each point, numbers from 0 along each axis.
    """
    across = cells.max(axis=0) + 1
    keys = (cells[:, 0] * across[1] + cells[:, 1]) * across[2] + cells[:, 2]
    _, place, count = np.unique(keys, return_inverse=True, return_counts=True)
    place = place.reshape(-1)
    means = np.stack([np.bincount(place, points[:, axis]) / count for axis in range(3)], axis=1)
    return means, place
