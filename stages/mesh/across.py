"""Fewer convex pieces for several parts of a link: pieces of different parts become one where they may.

Two halves of a case, or a motor in its holder, are each well within the tolerance in eight pieces, and nearly
as well together. What a step of a simulation costs is the number of pieces, and open_duck has 1,020 of them
part by part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.collision import Collision
from stages.mesh.convex_hull import convex_hull
from stages.mesh.decompose.joining import groups, joinings
from stages.mesh.decompose.overhang import Overhang
from stages.mesh.decompose.seams import containing
from stages.mesh.fit.score import MOST_OF_TOLERANCE
from stages.mesh.measure.judge import outer_samples
from stages.mesh.measure.union import Union
from stages.mesh.pieces import Piece, surface_of
from stages.mesh.surface import Points, Surface, joined
from stages.mesh.verdict import Judge, miss

_WORTH = (0.9, 0.7, 0.5)
"""Pieces are joined where one of these shares of them is near enough: with fewer there may be less that
stands out."""

MANY = 12
"""Fewer pieces of a link stay with their parts."""

_FINE = 0.5
"""The spacing of the points that stand for the parts in the verdict, in tolerances."""

_BURIED = 1e-3
"""How deep in another piece a point is within it, in tolerances."""

_POINTS = 5000
_SAFE = 0.8
"""Of the share that may stand out: so many points tell how large it is."""


def across(surfaces: Sequence[Surface], pieces: Sequence[Piece], settings: ColliderSettings) -> Collision:
    """Of parts and the pieces of all their colliders, in one frame: as few pieces as are near enough to the
    parts, each by the tolerance of the part that is nearest, or as near as the pieces were; none where that
    saves next to nothing.

    A joined piece holds those that it is made of, so no part is left barer than before. The tolerance of the
    whole is the largest of theirs.
    """
    none = Collision(meets=False)
    tolerances = [settings.tolerance_of(one) for one in surfaces]
    judge = Judge.of(joined(surfaces), replace(settings, tolerance=max(tolerances)))
    if isinstance(judge, str):
        return none
    corners = [_corners(piece) for piece in pieces]
    union = Union.of(pieces)

    def buried(points: Points) -> npt.NDArray[np.bool_]:
        # What is in a part is in its pieces, and what is in another piece is no surface.
        return union.depth(points) > _BURIED * judge.tolerance

    steps = joinings(corners, Overhang.of(surfaces, tolerances, buried), thin=0.0)
    verdict = Overhang.of(surfaces, tolerances, buried, _FINE, roughly=0.0)

    def taken(count: int) -> list[Piece]:
        found: list[Piece] = []
        for group in groups(len(corners), steps, count, 0.0):
            hull = convex_hull(np.concatenate([corners[one] for one in group]))
            if len(group) == 1 or hull is None:
                found += [pieces[one] for one in group]
            else:
                found.append(containing(hull, settings.max_vertices))
        return found

    before = _standing(verdict, pieces)

    def near(tried: Sequence[Piece]) -> bool:
        share, furthest = _standing(verdict, tried)
        return share <= max(_SAFE * 0.05, before[0]) and furthest <= max(MOST_OF_TOLERANCE, before[1])

    most = next((count for of in _WORTH if near(taken(count := int(of * len(pieces))))), 0)
    if not most:
        return none
    fewest, best = 0, taken(most)
    while most - fewest > max(1, most // 10):
        middle = (fewest + most) // 2
        tried = taken(middle)
        if near(tried):
            most, best = middle, tried
        else:
            fewest = middle
    measures = judge.measure(best)
    return judge.collision(best, measures, rung="pieces") if miss(measures, judge.tolerance) <= 1 else none


def _standing(verdict: Overhang, pieces: Sequence[Piece]) -> tuple[float, float]:
    """The share of the outer surface that stands out by more than the tolerance, and by how many tolerances
    it stands out at most."""
    far = verdict.standing(outer_samples(pieces, _POINTS))
    return float((far > 1).mean()), float(far.max(initial=0.0))


def _corners(piece: Piece) -> Points:
    return piece.vertices if isinstance(piece, Surface) else surface_of(piece).vertices
