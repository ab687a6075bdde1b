"""Where links are near each other, over the poses that colliders are made for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.contact.meeting_boxes import meeting_boxes
from linkwright.stages.robot.model.robot import Array

Bounds = tuple[Array, Array]
"""The lower and upper corners (n, 3) [m] of boxes in their links' frames."""


@dataclass(frozen=True, slots=True, eq=False)
class Near:
    """Two links, by number, and the poses in which their boxes meet, by number."""

    one: int
    other: int
    rows: npt.NDArray[np.int64]


def near_pairs(
    world_from_link: Sequence[Array], bounds: Bounds, margin: float, apart: set[tuple[int, int]]
) -> list[Near]:
    """The pairs of links whose boxes come within `margin` [m] of each other in some pose, in order, without
    those of `apart` (each the smaller number first). `world_from_link`: (poses, 4, 4) of each link.

    The work in each pose grows with the pairs that are near along the axis on which links are spread most.
    """
    middle, half = (bounds[0] + bounds[1]) / 2, (bounds[1] - bounds[0]) / 2
    places = np.stack(world_from_link)
    centres = np.einsum("lpij,lj->lpi", places[:, :, :3, :3], middle) + places[:, :, :3, 3]
    halves = np.einsum("lpij,lj->lpi", np.abs(places[:, :, :3, :3]), half) + margin / 2
    low, high = centres - halves, centres + halves
    count = len(world_from_link)
    forbidden = np.array(sorted(one * count + other for one, other in apart), dtype=np.int64)
    boxes = [meeting_boxes(low[:, row], high[:, row]) @ [count, 1] for row in range(places.shape[1])]
    met = [codes[~np.isin(codes, forbidden)] for codes in boxes]
    rows = np.repeat(np.arange(len(met)), [len(codes) for codes in met])
    codes = np.concatenate(met) if met else np.zeros(0, dtype=np.int64)
    order = np.lexsort((rows, codes))
    codes, rows = codes[order], rows[order]
    bounds_of = [*np.flatnonzero(np.diff(codes, prepend=-1)).tolist(), len(codes)]
    return [Near(int(codes[a]) // count, int(codes[a]) % count, rows[a:b]) for a, b in pairwise(bounds_of)]


def relative(one: Array, other: Array) -> Array:
    """one_from_other (n, 4, 4) of poses in a common frame."""
    turned = np.swapaxes(one[:, :3, :3], 1, 2)
    result = np.tile(np.eye(4), (len(one), 1, 1))
    result[:, :3, :3] = turned @ other[:, :3, :3]
    result[:, :3, 3] = np.einsum("nij,nj->ni", turned, other[:, :3, 3] - one[:, :3, 3])
    return result
