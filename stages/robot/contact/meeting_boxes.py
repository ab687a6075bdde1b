"""Finds the pairs of axis-aligned boxes that meet, without looking at all pairs."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array


def meeting_boxes(low: Array, high: Array) -> npt.NDArray[np.intp]:
    """Returns the pairs (k, 2) of axis-aligned boxes that meet or touch, as indices, in ascending order, the
    smaller index of a pair first. `low`, `high`: the corners (n, 3) of the boxes, with low <= high.

    The boxes are swept along the axis on which they are spread most, so the work grows with the number of
    pairs that overlap along this axis.
    """
    if not len(low):
        return np.zeros((0, 2), dtype=np.intp)
    axis = int(np.ptp(low + high, axis=0).argmax())
    order = np.argsort(low[:, axis], kind="stable")
    # Along the axis, each box overlaps the boxes behind it that start before it ends.
    ends = np.searchsorted(low[order, axis], high[order, axis], side="right")
    counts = ends - np.arange(len(low)) - 1
    first = np.repeat(np.arange(len(low)), counts)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    pairs = np.sort(np.stack([order[first], order[second]], axis=1), axis=1)
    first, second = pairs.T
    pairs = pairs[((low[first] <= high[second]) & (low[second] <= high[first])).all(axis=1)]
    meeting: npt.NDArray[np.intp] = pairs[np.lexsort(pairs.T[::-1])]
    return meeting
