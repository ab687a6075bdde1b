"""Finds the fewest shapes of two links that must not collide if the links touch in every pose.

Usually a single part of each link touches in every pose: two gears, a pin in a slot.
"""

from collections.abc import Hashable, Sequence

import numpy as np
import numpy.typing as npt

Mask = npt.NDArray[np.bool_]

MAX_OTHER_CONTACT_SHARE = 0.5
"""Largest share of the poses in which other pieces of two colliders may touch, if only the pieces that touch
in every pose are excluded. The teeth of two gears, for example, always touch somewhere, but no two of their
pieces always do."""


def excluded_shape_pairs(
    touching: Mask, first_colliders: Sequence[Hashable], second_colliders: Sequence[Hashable]
) -> Mask:
    """Returns the pairs of shapes (m, n) that must not collide; no pairs if there is a
    pose in which the links do not touch.

    `touching` (poses, m, n): whether each shape of the first link touches each shape of the second, pose by
    pose. `first_colliders` (m), `second_colliders` (n): the collider of which each shape is a piece.

    If two colliders touch in every pose, the pairs of their pieces that touch in every pose are excluded, or
    all pairs of their pieces if the other pairs touch in too many poses. If the remaining shapes of the links
    still touch in every pose, all pairs of shapes are excluded.
    """
    excluded = np.zeros(touching.shape[1:], dtype=bool)
    if not _touch_in_every_pose(touching):
        return excluded
    for rows in _indices_by_label(first_colliders):
        for columns in _indices_by_label(second_colliders):
            excluded[np.ix_(rows, columns)] = _excluded_piece_pairs(touching[:, rows][:, :, columns])
    return np.ones_like(excluded) if _touch_in_every_pose(touching & ~excluded) else excluded


def _excluded_piece_pairs(touching: Mask) -> Mask:
    """Returns the pairs of pieces (m, n) of two colliders that must not collide, as `excluded_shape_pairs`
    chooses them. `touching`: (poses, m, n)."""
    if not _touch_in_every_pose(touching):
        return np.zeros(touching.shape[1:], dtype=bool)
    always_touching: Mask = np.logical_and.reduce(touching)
    has_other_contact = (touching & ~always_touching).any(axis=(1, 2))
    if has_other_contact.mean() <= MAX_OTHER_CONTACT_SHARE:
        return always_touching
    return np.ones_like(always_touching)


def _touch_in_every_pose(touching: Mask) -> bool:
    """Tells whether in every pose at least one pair touches, not always the same pair; false without poses.
    `touching`: (poses, m, n)."""
    return len(touching) > 0 and bool(touching.any(axis=(1, 2)).all())


def _indices_by_label(labels: Sequence[Hashable]) -> list[list[int]]:
    """Returns a list for each distinct label: the indices of the entries with this label."""
    groups: dict[Hashable, list[int]] = {}
    for index, label in enumerate(labels):
        groups.setdefault(label, []).append(index)
    return list(groups.values())
