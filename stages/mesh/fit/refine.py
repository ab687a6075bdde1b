"""Small steps towards a better fit: single sides of a primitive in or out."""

from dataclasses import replace

import numpy as np

from linkwright.stages.mesh.fit.outline import Outline
from linkwright.stages.mesh.fit.score import error
from linkwright.stages.robot.model.robot import Primitive, frozen

_WORTH_IT = 2.0
"""Of an error of more than so many times the usual tolerance no small steps make a good fit."""

_GOOD = 0.5
_STEPS = (0.5, 0.25, 0.125)
"""Lengths of steps, as shares of the error at first."""

_GAIN = 0.99

Side = tuple[int, int]
"""Which of a primitive's sizes, and at which of its ends: -1 or 1, or 0 for a radius."""


def refined_below(outline: Outline) -> float:
    """The error [m] from which on a fit gets no small steps."""
    return _WORTH_IT * outline.tolerance


def refined(primitive: Primitive, first: float, outline: Outline) -> tuple[Primitive, float]:
    """The primitive with its sides moved so that its error [m], `first`, is less, and that error.

    All sides that are better moved alone are moved together, so that neither their order nor their sense
    matters; where that is worse, the best of them is moved alone.
    """
    if not _GOOD * outline.tolerance < first < refined_below(outline):
        return primitive, first
    least = first
    for share in _STEPS:
        step, limit = share * first, _GAIN * least
        moves = [_best_move(primitive, side, step, limit, outline) for side in _sides(primitive)]
        better = [move for move in moves if move is not None]
        if not better:
            continue
        together = primitive
        for _, side, amount in better:
            together = _stretched(together, side, amount)
        score, side, amount = min(better)
        common = error(together, outline)
        primitive = together if common <= score else _stretched(primitive, side, amount)
        least = min(common, score)
    return primitive, least


def _best_move(
    primitive: Primitive, side: Side, step: float, limit: float, outline: Outline
) -> tuple[float, Side, float] | None:
    """The error [m] after a side has moved by `step` in or out, whichever is better, the side, and how far;
    None where it is not below `limit`."""
    index, _ = side
    found = []
    for amount in (-step, step):
        if primitive.size[index] + amount > step:
            there = _stretched(primitive, side, amount)
            if outline.bareness(there) < limit and (score := error(there, outline)) < limit:
                found.append((score, side, amount))
    return min(found, default=None)


def _sides(primitive: Primitive) -> tuple[Side, ...]:
    if primitive.kind == "box":
        return tuple((axis, end) for axis in range(3) for end in (-1, 1))
    return ((0, 0),) if primitive.kind == "sphere" else ((0, 0), (1, -1), (1, 1))


def _stretched(primitive: Primitive, side: Side, amount: float) -> Primitive:
    """The primitive with one side further out by `amount` [m]."""
    index, end = side
    size = list(primitive.size)
    size[index] += amount
    pose = np.array(primitive.link_from_shape)
    axis = pose[:3, index if primitive.kind == "box" else 2]
    pose[:3, 3] += axis * (end * amount / 2)
    return replace(primitive, size=tuple(size), link_from_shape=frozen(pose))
