"""The cheapest collider that is near enough to the part: a primitive, the convex hull, or convex pieces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from linkwright.stages.formats.meshes.surface import Surface, joined
from linkwright.stages.mesh.collide.acceptance import Judge, miss
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.cut_pieces import Cut, PieceCutter
from linkwright.stages.mesh.colliders import hull
from linkwright.stages.mesh.configuration.collider_settings import HullSettings, LadderSettings
from linkwright.stages.mesh.fit import CHEAPEST, capped_hull, fits
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import Piece, surface_of
from linkwright.stages.mesh.surfaces.snapping import snapped
from linkwright.stages.robot.model.robot import PrimitiveKind

_WORTH = 2.0
"""Pieces that miss the tolerance are taken where they are so many times nearer than the hull: of the open
sheets of a cover 16 pieces are a third nearer, at a tenth of the speed."""

_NEAR = 1.3
"""A fit whose error is at most so many tolerances is measured: the error is known from few points."""


_HOLLOW = 2.0
"""A part whose hull misses so many times the tolerance is no primitive."""


_NEAR_PIECE = 0.75
"""A fit is tried whose error, against its piece, is at most so many tolerances."""

_CHEAP: tuple[PrimitiveKind, ...] = ("sphere", "capsule", "box")
"""No cylinder, which costs an engine as much as a hull."""

_MOST_TRIES = 6


def make(surfaces: Sequence[Surface], settings: LadderSettings) -> Collision:
    """The cheapest primitive that is near enough, else the convex hull, near enough or not."""
    judge = Judge.of(joined(surfaces), settings.tolerance, settings.extra_volume)
    if isinstance(judge, str):
        whole = hull.make(surfaces, HullSettings(settings.max_vertices))
        return replace(whole, meets=not whole.pieces, note=judge)
    for rung, piece in _wholes(judge, settings):
        if judge.hopeless([piece]) and rung != "hull":
            continue
        measures = judge.measure([piece])
        meets = judge.whole_meets(measures)
        if meets or rung == "hull":
            return judge.collision((piece,), measures, rung, meets)
    return Collision(note="the part is flat")


def _wholes(judge: Judge, settings: LadderSettings) -> Iterator[tuple[str, Piece]]:
    """The primitives worth a measurement, the cheapest first, then the hull."""
    whole = convex_hull(judge.surface.vertices)
    if whole is None:
        return
    # What leaves no more than a tolerance of the part bare stands out nearly as far as the hull does.
    if not judge.hopeless([whole], _HOLLOW):
        for fitted in fits(judge.surface, CHEAPEST[settings.target], _NEAR * judge.tolerance):
            yield fitted.primitive.kind, fitted.primitive
    capped = capped_hull(judge.surface, settings.max_vertices)
    if capped is not None:
        yield "hull", snapped(capped)


def improve(surfaces: Sequence[Surface], settings: LadderSettings, made: Collision) -> Collision:
    """Convex pieces, as few as are near enough; or, where none are, those that are much nearer than the hull;
    else `made`."""
    judge = Judge.of(joined(surfaces), settings.tolerance, settings.extra_volume)
    if isinstance(judge, str) or made.measures is None:
        return made
    cut = PieceCutter(judge, settings.max_vertices, settings.effort).cut()
    return _of_pieces(judge, cut, made) if cut.pieces else made


def _of_pieces(judge: Judge, cut: Cut, hull: Collision) -> Collision:
    """The collider of these pieces, with primitives where they are as near; where they miss the tolerance,
    only if they are so much nearer than the `hull` that they are worth what they cost a simulation; else the
    hull, which says how near they would be."""
    taken = _plainer(judge, [*map(surface_of, cut.pieces)]) if cut.near else cut.pieces
    measures = judge.measure(taken)
    off = miss(measures, judge.tolerance)
    if off <= 1 or hull.measures is None:
        return judge.collision(taken, measures, "pieces", off <= 1)
    times = miss(hull.measures, judge.tolerance) / off
    if times >= _WORTH:
        return judge.collision(taken, measures, "pieces", meets=False)
    return hull.with_note(f"{len(cut.pieces)} convex pieces are {times:.2g} times as near")


def _plainer(judge: Judge, hulls: Sequence[Surface]) -> tuple[Piece, ...]:
    """Pieces that are near enough, as many of them as primitives as the tolerance allows.

    All that fit their pieces are tried at once; where that is too far off, the half of them that fits best.
    """
    cheapest = (next(fits(hull, _CHEAP, _NEAR_PIECE * judge.tolerance), None) for hull in hulls)
    fitted = {index: one for index, one in enumerate(cheapest) if one}
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


def together(surfaces: Sequence[Surface], settings: LadderSettings) -> Collision:
    """One primitive or hull for several parts, where it is as near as each of them asks; else no pieces."""
    tolerance = min(map(settings.tolerance_of, surfaces))
    every = joined(surfaces)
    whole = convex_hull(every.vertices)
    if whole is None or whole.volume() > _filled(surfaces, tolerance, settings.extra_volume):
        return Collision(meets=False)
    made = make([every], replace(settings, tolerance=tolerance))
    return made if made.meets and made.pieces else Collision(meets=False)


def _filled(surfaces: Sequence[Surface], tolerance: float, extra_volume: float) -> float:
    """The largest volume [m³] of a hull of all that is worth a look."""
    volume = sum(abs(surface.volume()) for surface in surfaces)
    skin = tolerance * sum(surface.area() for surface in surfaces)
    return volume + extra_volume * (volume + skin)
