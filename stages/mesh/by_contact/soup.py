"""Triangles without shared corners, cut by planes; each side's convex hull is a piece of a collider."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stages.mesh.surface import Points

Soup = npt.NDArray[np.float64]
"""(m, 3, 3): the three corners [m] of each triangle. Surfaces with holes are cut as closed ones are."""


def cut(soup: Soup, normal: Points, height: float) -> tuple[Soup, Soup]:
    """What is on the side where normal·x ≤ height, and what is on the other; normal (3,)."""
    above = soup @ normal - height
    high = above > 0
    count = high.sum(axis=1)
    below, over = [soup[count == 0]], [soup[count == 3]]
    for number, alone_side, pair_side in ((1, over, below), (2, below, over)):
        rows = np.flatnonzero(count == number)
        if not len(rows):
            continue
        corner = (high[rows] if number == 1 else ~high[rows]).argmax(axis=1)
        order = (corner[:, None] + np.arange(3)) % 3
        alone, first, second = np.moveaxis(np.take_along_axis(soup[rows], order[:, :, None], axis=1), 1, 0)
        heights = np.take_along_axis(above[rows], order, axis=1)
        to_first, to_second = (
            alone + (heights[:, :1] / (heights[:, :1] - heights[:, [k]])) * (end - alone)
            for k, end in ((1, first), (2, second))
        )
        alone_side.append(np.stack([alone, to_first, to_second], axis=1))
        pair_side.append(np.stack([to_first, first, second], axis=1))
        pair_side.append(np.stack([to_first, second, to_second], axis=1))
    return np.concatenate(below), np.concatenate(over)
