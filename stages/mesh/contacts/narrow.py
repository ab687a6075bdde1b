"""Which shapes of two links do not collide, where the links touch in every pose: as few as will do.

What meets in every pose is mostly a part of the one link and one of the other: two gears, a pin in a slot.
"""

from collections.abc import Hashable, Sequence

import numpy as np
import numpy.typing as npt

Mask = npt.NDArray[np.bool_]

SELDOM = 0.5
"""Pieces of two colliders that touch in more than this share of the poses belong to what always touches: such
as the teeth of two gears, of which no two pieces are always in each other, but some always are."""


def narrowed(touching: Mask, one: Sequence[Hashable], other: Sequence[Hashable]) -> Mask:
    """The pairs of shapes (m, n) that do not collide; none where the links are apart in some pose.

    `touching` (poses, m, n): whether each shape of the one link touches each of the other. `one` (m) and
    `other` (n): which collider each shape is a piece of. Of two colliders that touch in every pose those
    pieces are left out that do so, if the others are mostly apart; else all of them. All shapes are left out
    where the links touch in every pose, but no two colliders do, or where what is left still does.
    """
    found = np.zeros(touching.shape[1:], dtype=bool)
    if not _always(touching):
        return found
    for rows in _groups(one):
        for columns in _groups(other):
            block = np.ix_(rows, columns)
            found[block] = _of_two_colliders(touching[:, rows][:, :, columns])
    return np.ones_like(found) if _always(touching & ~found) else found


def _of_two_colliders(touching: Mask) -> Mask:
    """The pairs of pieces of two colliders that do not collide."""
    if not _always(touching):
        return np.zeros(touching.shape[1:], dtype=bool)
    always: Mask = np.logical_and.reduce(touching)
    rest = (touching & ~always).any(axis=(1, 2))
    return always if rest.mean() <= SELDOM else np.ones_like(always)


def _always(touching: Mask) -> bool:
    """Whether something touches in every pose; never without a pose."""
    return len(touching) > 0 and bool(touching.any(axis=(1, 2)).all())


def _groups(labels: Sequence[Hashable]) -> list[list[int]]:
    """The positions that have one label, for each label."""
    found: dict[Hashable, list[int]] = {}
    for index, label in enumerate(labels):
        found.setdefault(label, []).append(index)
    return list(found.values())
