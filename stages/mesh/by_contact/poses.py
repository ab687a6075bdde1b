"""Finds the pairs of links that come near each other, and the poses in which they do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.contact.meeting_boxes import meeting_boxes
from linkwright.stages.robot.model.robot import Array

Bounds = tuple[Array, Array]
"""Lower and upper corners (n, 3) [m] of boxes in their links' frames."""


@dataclass(frozen=True, slots=True, eq=False)
class NearPair:
    """Indices of two links, and of the poses in which their boxes meet."""

    first_link: int
    second_link: int
    rows: npt.NDArray[np.int64]


def near_pairs(
    world_from_link: Sequence[Array], bounds: Bounds, margin: float, apart: set[tuple[int, int]]
) -> list[NearPair]:
    """Returns the pairs of links whose boxes come within `margin` [m] of each other in some pose, in order.
    Pairs of `apart` (the smaller index first) are left out. `world_from_link`: poses (n, 4, 4) of each link.

    The work for each pose grows with the pairs that are near along the axis on which links are spread most.
    """
    centres_in_link, half = (bounds[0] + bounds[1]) / 2, (bounds[1] - bounds[0]) / 2
    poses = np.stack(world_from_link)
    centres = np.einsum("lpij,lj->lpi", poses[:, :, :3, :3], centres_in_link) + poses[:, :, :3, 3]
    halves = np.einsum("lpij,lj->lpi", np.abs(poses[:, :, :3, :3]), half) + margin / 2
    low, high = centres - halves, centres + halves
    count = len(world_from_link)
    excluded_codes = np.array(sorted(first * count + second for first, second in apart), dtype=np.int64)
    boxes = [meeting_boxes(low[:, row], high[:, row]) @ [count, 1] for row in range(poses.shape[1])]
    codes_of_rows = [codes[~np.isin(codes, excluded_codes)] for codes in boxes]
    rows = np.repeat(np.arange(len(codes_of_rows)), [len(codes) for codes in codes_of_rows])
    codes = np.concatenate(codes_of_rows) if codes_of_rows else np.zeros(0, dtype=np.int64)
    order = np.lexsort((rows, codes))
    codes, rows = codes[order], rows[order]
    # A pair of links is coded as first * count + second; equal codes are next to each other.
    begins = [*np.flatnonzero(np.diff(codes, prepend=-1)).tolist(), len(codes)]
    return [
        NearPair(int(codes[begin]) // count, int(codes[begin]) % count, rows[begin:end])
        for begin, end in pairwise(begins)
    ]


def relative(first: Array, second: Array) -> Array:
    """Returns first_from_second (n, 4, 4) of poses in a common frame."""
    inverse_rotations = np.swapaxes(first[:, :3, :3], 1, 2)
    result = np.tile(np.eye(4), (len(first), 1, 1))
    result[:, :3, :3] = inverse_rotations @ second[:, :3, :3]
    result[:, :3, 3] = np.einsum("nij,nj->ni", inverse_rotations, second[:, :3, 3] - first[:, :3, 3])
    return result
