"""Convex pieces of a collider as primitives, where those are as near to the part."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stages.mesh.fit.kinds import Fitted, best, subject_of
from stages.mesh.pieces import Piece
from stages.mesh.surface import Surface
from stages.mesh.verdict import Judge
from stages.robot.model import PrimitiveKind

_NEAR = 0.75
"""A fit is tried whose error, against its piece, is at most so many tolerances."""

_MOST_TRIES = 6


def plainer(judge: Judge, hulls: Sequence[Surface]) -> tuple[Piece, ...]:
    """Pieces that are near enough, as many of them as primitives as the tolerance allows.

    All that fit their pieces are tried at once; where that is too far off, the half of them that fits best.
    """
    fitted = {index: one for index, hull in enumerate(hulls) if (one := _fit(hull, judge.tolerance))}
    ranked = sorted(fitted, key=lambda index: (fitted[index].error, index))
    for _ in range(_MOST_TRIES):
        if not ranked:
            break
        tried: list[Piece] = list(hulls)
        for index in ranked:
            tried[index] = fitted[index].primitive
        if not judge.hopeless(tried) and judge.near(tried):
            return tuple(tried)
        ranked = ranked[: len(ranked) // 2]
    return tuple(hulls)


def _fit(hull: Surface, tolerance: float) -> Fitted | None:
    """The cheapest primitive that fits; no cylinder, which costs an engine as much as a hull."""
    subject = subject_of(hull)
    if subject is None:
        return None
    found = (best(kind, subject) for kind in _likely(hull, tolerance))
    return next((one for one in found if one.error <= _NEAR * tolerance), None)


def _likely(hull: Surface, tolerance: float) -> Iterator[PrimitiveKind]:
    """The kinds whose proportions a convex piece has, roughly: a fit of another one is wasted work."""
    widths = np.sort(_widths(hull.vertices))
    slack = 4 * tolerance
    if widths[2] - widths[0] <= slack:
        yield "sphere"
    if widths[1] - widths[0] <= slack:
        yield "capsule"
    yield "box"


def _widths(points: np.ndarray) -> np.ndarray:
    """How wide points are along their principal axes [m]."""
    apart = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(apart.T @ apart)
    return np.asarray(np.ptp(apart @ axes, axis=0), dtype=np.float64)
