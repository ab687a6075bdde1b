"""Finds the fewest shapes of two links that must not collide if the links touch in every pose.

Usually a single part of each link touches in every pose: two gears, a pin in a slot.
"""

from collections.abc import Hashable, Sequence

import numpy as np
import numpy.typing as npt

Mask = npt.NDArray[np.bool_]

MAX_SHARE_OF_OTHERS = 0.5
"""Largest share of the poses in which other pieces of two colliders touch, if only the pieces that touch in
every pose are left out. The teeth of two gears, for example, always touch somewhere, but no two of their
pieces always do."""


def narrowed(touching: Mask, first: Sequence[Hashable], second: Sequence[Hashable]) -> Mask:
    """Returns the pairs of shapes (m, n) that must not collide; no pairs if the links are apart in some pose.

    `touching` (poses, m, n): whether each shape of the first link touches each shape of the second. `first`
    (m), `second` (n): the collider of which each shape is a piece. If two colliders touch in every pose,
    those of their pieces that touch in every pose are left out if the other pieces are mostly apart, else all
    pieces. All shapes are left out if the remaining shapes still touch in every pose.
    """
    mask = np.zeros(touching.shape[1:], dtype=bool)
    if not _always(touching):
        return mask
    for rows in _groups(first):
        for columns in _groups(second):
            block = np.ix_(rows, columns)
            mask[block] = _narrowed_pieces(touching[:, rows][:, :, columns])
    return np.ones_like(mask) if _always(touching & ~mask) else mask


def _narrowed_pieces(touching: Mask) -> Mask:
    """Returns the pairs of pieces of two colliders that must not collide."""
    if not _always(touching):
        return np.zeros(touching.shape[1:], dtype=bool)
    always: Mask = np.logical_and.reduce(touching)
    rest = (touching & ~always).any(axis=(1, 2))
    return always if rest.mean() <= MAX_SHARE_OF_OTHERS else np.ones_like(always)


def _always(touching: Mask) -> bool:
    """Tells whether something touches in every pose; false without poses."""
    return len(touching) > 0 and bool(touching.any(axis=(1, 2)).all())


def _groups(labels: Sequence[Hashable]) -> list[list[int]]:
    """Returns for each label the indices that have it."""
    groups: dict[Hashable, list[int]] = {}
    for index, label in enumerate(labels):
        groups.setdefault(label, []).append(index)
    return list(groups.values())
