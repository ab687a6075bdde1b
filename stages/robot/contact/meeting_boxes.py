"""Finds the pairs of boxes that meet, without looking at all pairs."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array


def meeting_boxes(low: Array, high: Array) -> npt.NDArray[np.intp]:
    """Returns the pairs (k, 2) of boxes that meet, by number, sorted, the smaller number first.

    `low`, `high`: their corners (n, 3). A sweep along the axis on which they are spread most: the work grows
    with the number of pairs that are near along it.
    """
    if not len(low):
        return np.zeros((0, 2), dtype=np.intp)
    axis = int(np.ptp(low + high, axis=0).argmax())
    order = np.argsort(low[:, axis], kind="stable")
    reached = np.searchsorted(low[order, axis], high[order, axis], side="right")
    counts = reached - np.arange(len(low)) - 1
    first = np.repeat(np.arange(len(low)), counts)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    pairs = np.sort(np.stack([order[first], order[second]], axis=1), axis=1)
    a, b = pairs.T
    pairs = pairs[((low[a] <= high[b]) & (low[b] <= high[a])).all(axis=1)]
    meeting: npt.NDArray[np.intp] = pairs[np.lexsort(pairs.T[::-1])]
    return meeting
