"""Improves a fit in small steps, which move single sides of a primitive in or out."""

from dataclasses import replace

import numpy as np

from linkwright.stages.mesh.fit.outline import Outline
from linkwright.stages.mesh.fit.score import primitive_error
from linkwright.stages.robot.model.robot import Primitive, frozen

_MAX_FIRST_ERROR = 2.0
"""Largest error, in default tolerances, of a fit that small steps can make good."""

_GOOD_ERROR = 0.5
"""Error, in default tolerances, below which a fit is good enough without steps."""

_STEPS = (0.5, 0.25, 0.125)
"""Lengths of the steps, as shares of the error before the first step."""

_MAX_ERROR_RATIO = 0.99
"""Largest ratio between the errors after and before a step that is taken."""

Side = tuple[int, int]
"""Index of one of a primitive's lengths, and the end that moves: -1 or 1, or 0 for a radius."""


def max_refined_error(outline: Outline) -> float:
    """Returns the error [m] from which a fit is too bad to be refined."""
    return _MAX_FIRST_ERROR * outline.tolerance


def refined(primitive: Primitive, first_error: float, outline: Outline) -> tuple[Primitive, float]:
    """Moves the sides of a primitive to reduce its error [m], `first_error`; returns the primitive and its
    error.

    In each step, all sides whose single moves reduce the error are moved together, so that neither their
    order nor their sense matters; if that is worse than the best single move, only that one is made.
    """
    if not _GOOD_ERROR * outline.tolerance < first_error < max_refined_error(outline):
        return primitive, first_error
    least_error = first_error
    for share in _STEPS:
        step, limit = share * first_error, _MAX_ERROR_RATIO * least_error
        moves = [_best_move(primitive, side, step, limit, outline) for side in _sides(primitive)]
        useful_moves = [move for move in moves if move is not None]
        if not useful_moves:
            continue
        primitive_moved = primitive
        for _, side, amount in useful_moves:
            primitive_moved = _stretched(primitive_moved, side, amount)
        score, side, amount = min(useful_moves)
        common = primitive_error(primitive_moved, outline)
        primitive = primitive_moved if common <= score else _stretched(primitive, side, amount)
        least_error = min(common, score)
    return primitive, least_error


def _best_move(
    primitive: Primitive, side: Side, step: float, limit: float, outline: Outline
) -> tuple[float, Side, float] | None:
    """Moves a side by `step` [m] in or out, whichever is better; returns the error [m], the side, and the
    signed distance. None if the error is not below `limit`."""
    index, _ = side
    moves = []
    for amount in (-step, step):
        if primitive.size[index] + amount > step:
            moved_primitive = _stretched(primitive, side, amount)
            if (
                outline.bareness(moved_primitive) < limit
                and (score := primitive_error(moved_primitive, outline)) < limit
            ):
                moves.append((score, side, amount))
    return min(moves, default=None)


def _sides(primitive: Primitive) -> tuple[Side, ...]:
    if primitive.kind == "box":
        return tuple((axis, end) for axis in range(3) for end in (-1, 1))
    return ((0, 0),) if primitive.kind == "sphere" else ((0, 0), (1, -1), (1, 1))


def _stretched(primitive: Primitive, side: Side, amount: float) -> Primitive:
    """Returns the primitive with a side moved outwards by `amount` [m]."""
    index, end = side
    size = list(primitive.size)
    size[index] += amount
    pose = np.array(primitive.link_from_shape)
    axis = pose[:3, index if primitive.kind == "box" else 2]
    pose[:3, 3] += axis * (end * amount / 2)
    return replace(primitive, size=tuple(size), link_from_shape=frozen(pose))
