"""Convex pieces of a collider as primitives, where those are as near to the part."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.collide.acceptance import Judge
from linkwright.stages.mesh.fit import fits
from linkwright.stages.mesh.surfaces.pieces import Piece

if TYPE_CHECKING:
    from linkwright.stages.mesh.fit.kinds import Fitted
    from linkwright.stages.robot.model.robot import PrimitiveKind

_NEAR = 0.75
"""A fit is tried whose error, against its piece, is at most so many tolerances."""

_KINDS: tuple[PrimitiveKind, ...] = ("sphere", "capsule", "box")
"""No cylinder, which costs an engine as much as a hull."""

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
    """The cheapest primitive that fits."""
    return next(fits(hull, _KINDS, _NEAR * tolerance), None)
