"""Makes the cheapest collider that is near enough to a part: a primitive, its hull, or convex pieces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from linkwright.stages.formats.meshes.surface import Surface, join_surfaces
from linkwright.stages.mesh.collide.acceptance import Judge, miss
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.cut_pieces import Cut, PieceCutter
from linkwright.stages.mesh.colliders import hull
from linkwright.stages.mesh.configuration.collider_settings import HullSettings, LadderSettings
from linkwright.stages.mesh.fit import allowed_kinds, capped_hull, fits
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import Piece, surface_of
from linkwright.stages.mesh.surfaces.snapping import snapped
from linkwright.stages.robot.model.robot import PrimitiveKind

_MIN_GAIN_OF_PIECES = 2.0
"""Pieces that miss the tolerance must be at least this many times nearer than the hull: for the open sheets
of a cover, 16 pieces are a third nearer, but simulate at a tenth of the speed."""

_MAX_FIT_ERROR = 1.3
"""Largest error, in tolerances, of fits that are measured: the error is only estimated, from few points."""


_MAX_HULL_MISS = 2.0
"""Parts whose hull is off by more than this many tolerances are not tried as primitives."""


_MAX_PIECE_FIT_ERROR = 0.75
"""Largest error, in tolerances, of primitives that may replace a piece."""

_CHEAP_KINDS: tuple[PrimitiveKind, ...] = ("sphere", "capsule", "box")
"""Kinds of primitives that may replace a piece. A cylinder costs an engine as much as a hull."""

_MAX_TRIES = 6  # each with half as many primitives as the one before


def make(surfaces: Sequence[Surface], settings: LadderSettings) -> Collision:
    """Makes the cheapest primitive that is near enough, else the convex hull, near enough or not."""
    judge = Judge.of(join_surfaces(surfaces), settings.tolerance, settings.extra_volume)
    if isinstance(judge, str):
        hull_collider = hull.make(surfaces, HullSettings(settings.max_vertices))
        return replace(hull_collider, meets=not hull_collider.pieces, note=judge)
    for rung, piece in _single_pieces(judge, settings):
        if judge.is_hopeless([piece]) and rung != "hull":
            continue
        measures = judge.measure([piece])
        meets = judge.whole_meets(measures)
        if meets or rung == "hull":
            return judge.collision((piece,), measures, rung, meets)
    return Collision(note="the part is flat")


def _single_pieces(judge: Judge, settings: LadderSettings) -> Iterator[tuple[str, Piece]]:
    """Yields the primitives that are worth a measurement, the cheapest first, then the hull."""
    whole_hull = convex_hull(judge.surface.vertices)
    if whole_hull is None:
        return
    # A primitive that covers the part up to a tolerance stands out nearly as far as the hull.
    if not judge.is_hopeless([whole_hull], _MAX_HULL_MISS):
        for fitted in fits(judge.surface, allowed_kinds(settings.limits), _MAX_FIT_ERROR * judge.tolerance):
            yield fitted.primitive.kind, fitted.primitive
    capped = capped_hull(judge.surface, settings.max_vertices)
    if capped is not None:
        yield "hull", snapped(capped)


def improve(surfaces: Sequence[Surface], settings: LadderSettings, first_collider: Collision) -> Collision:
    """Makes the fewest convex pieces that are near enough; else pieces that are much nearer than the hull;
    else returns `first_collider`."""
    judge = Judge.of(join_surfaces(surfaces), settings.tolerance, settings.extra_volume)
    if isinstance(judge, str) or first_collider.measures is None:
        return first_collider
    cut = PieceCutter(judge, settings.max_vertices, settings.effort).cut()
    return _collider_of_pieces(judge, cut, first_collider) if cut.pieces else first_collider


def _collider_of_pieces(judge: Judge, cut: Cut, whole_hull: Collision) -> Collision:
    """Returns the collider of cut pieces, some of them replaced by primitives. Pieces that miss the tolerance
    are used only if they are so much nearer than the `whole_hull` that they are worth their cost in a
    simulation; otherwise returns the hull, with a note on how near the pieces would be."""
    pieces = _with_primitives(judge, [*map(surface_of, cut.pieces)]) if cut.meets_tolerance else cut.pieces
    measures = judge.measure(pieces)
    misses = miss(measures, judge.tolerance)
    if misses <= 1 or whole_hull.measures is None:
        return judge.collision(pieces, measures, "pieces", misses <= 1)
    gain = miss(whole_hull.measures, judge.tolerance) / misses
    if gain >= _MIN_GAIN_OF_PIECES:
        return judge.collision(pieces, measures, "pieces", meets=False)
    return whole_hull.with_note(f"{len(cut.pieces)} convex pieces are {gain:.2g} times as near")


def _with_primitives(judge: Judge, hulls: Sequence[Surface]) -> tuple[Piece, ...]:
    """Replaces pieces that are near enough by primitives, as many as the tolerance allows.

    All primitives that fit their pieces are tried at once; if the result is too far off, the better-fitting
    half of them is tried, and so on.
    """
    cheapest = (
        next(fits(surface, _CHEAP_KINDS, _MAX_PIECE_FIT_ERROR * judge.tolerance), None) for surface in hulls
    )
    fitted = {index: fit for index, fit in enumerate(cheapest) if fit}
    ranked = sorted(fitted, key=lambda index: (fitted[index].error, index))
    for _ in range(_MAX_TRIES):
        if not ranked:
            break
        pieces: list[Piece] = list(hulls)
        for index in ranked:
            pieces[index] = fitted[index].primitive
        if not judge.is_hopeless(pieces) and judge.is_near(pieces):
            return tuple(pieces)
        ranked = ranked[: len(ranked) // 2]
    return tuple(hulls)


def together(surfaces: Sequence[Surface], settings: LadderSettings) -> Collision:
    """Makes one primitive or hull for several parts if it is within the tolerance of each; else no pieces."""
    tolerance = min(map(settings.tolerance_of, surfaces))
    combined = join_surfaces(surfaces)
    whole_hull = convex_hull(combined.vertices)
    if whole_hull is None or whole_hull.volume() > _largest_volume(
        surfaces, tolerance, settings.extra_volume
    ):
        return Collision(meets=False)
    collision = make([combined], replace(settings, tolerance=tolerance))
    return collision if collision.meets and collision.pieces else Collision(meets=False)


def _largest_volume(surfaces: Sequence[Surface], tolerance: float, extra_volume: float) -> float:
    """Returns the largest volume [m³] of a common hull that is worth a try."""
    volume = sum(abs(surface.volume()) for surface in surfaces)
    skin = tolerance * sum(surface.area() for surface in surfaces)
    return volume + extra_volume * (volume + skin)
