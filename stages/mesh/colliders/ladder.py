"""The cheapest collider that is near enough to the part: a primitive, the convex hull, or convex pieces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.colliders import hull
from stages.mesh.collision import Collision
from stages.mesh.convex_hull import convex_hull
from stages.mesh.decompose import (
    MOST_PIECES,
    DecomposeOptions,
    Decomposition,
    decomposition,
    hole,
    pieces,
    read,
    search,
)
from stages.mesh.fit import CHEAPEST, capped_hull, fits
from stages.mesh.pieces import Piece
from stages.mesh.plainer import plainer
from stages.mesh.snapping import snapped
from stages.mesh.surface import Surface, joined
from stages.mesh.verdict import Judge, miss
from stages.robot.guest import Guest


@dataclass(frozen=True, slots=True)
class Attempt:
    """How a part is decomposed: how finely, as a share of the tolerance; whether with half of the search and
    a larger threshold; and whether cut into sectors around its hole first, where it has one."""

    share: float = 1.0
    hasty: bool = False
    sectors: bool = False


_FEWEST = 2
"""Pieces: one is the hull, which is not near enough where it comes to pieces."""

_ATTEMPTS = (
    Attempt(hasty=True),
    Attempt(hasty=True, sectors=True),
    Attempt(),
    Attempt(0.7),
)
"""The first of them is enough for three in four of the parts of the sample and so101 that no hull is near."""

_THOROUGH = (
    Attempt(),
    Attempt(sectors=True),
    Attempt(0.7),
)
"""Where the user gives a tolerance, for a hole or an edge that matters: half of the search finds pieces of
which few points stand out, but one corner by twice the tolerance."""

_COARSER = 1.4
"""The threshold of a hasty attempt, of the usual one: it takes three quarters of the time."""

_IN_REACH = 1.5
_MANY = 48
"""A part that is off by more times the tolerance is not decomposed more finely where it is in many more
pieces than it may have, since that would give yet more, nor where they are of a surface around it, which may
be no nearer."""

_LOOK = 2000
"""Points of a look whether so many pieces may be near enough: a fifth of what a measurement takes, and it
errs by a piece or two."""

_WORTH = 2.0
"""Pieces that miss the tolerance are taken where they are so many times nearer than the hull: of the open
sheets of a cover 16 pieces are a third nearer, at a tenth of the speed."""

_NEAR = 1.3
"""A fit whose error is at most so many tolerances is measured: the error is known from few points."""


_HOLLOW = 2.0
"""A part whose hull misses so many times the tolerance is no primitive."""


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """The cheapest primitive that is near enough, else the convex hull, near enough or not."""
    judge = Judge.of(joined(surfaces), settings)
    if isinstance(judge, str):
        whole = hull.make(surfaces, settings)
        return replace(whole, meets=not whole.pieces, note=judge)
    for rung, piece in _wholes(judge, settings):
        if judge.hopeless([piece]) and rung != "hull":
            continue
        measures = judge.measure([piece])
        meets = judge.whole_meets(measures)
        if meets or rung == "hull":
            return judge.collision((piece,), measures, rung, meets)
    return Collision(note="the part is flat")


def _wholes(judge: Judge, settings: ColliderSettings) -> Iterator[tuple[str, Piece]]:
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


def improve(
    surfaces: Sequence[Surface], settings: ColliderSettings, made: Collision, guest: Guest
) -> Collision:
    """Convex pieces, as few as are near enough; or, where none are, those that are much nearer than the hull;
    else `made`.

    DecompositionFailed where the guest fails: nothing to keep.
    """
    judge = Judge.of(joined(surfaces), settings)
    if isinstance(judge, str) or made.measures is None:
        return made
    best = made
    out_of_reach = False
    for attempt in _ATTEMPTS if settings.tolerance is None else _THOROUGH:
        if hole(judge.surface, judge.tolerance) is None if attempt.sectors else out_of_reach:
            continue
        how = search(settings.effort, settings.coacd, attempt.hasty)
        coarser = _COARSER if attempt.hasty else 1.0
        tolerance = attempt.share * judge.tolerance
        options = DecomposeOptions(tolerance, search=how, sectors=attempt.sectors, coarser=coarser)
        found = read(decomposition(judge.surface, options, guest))
        if found.refused:
            return _worthwhile(best, made, judge.tolerance).with_note(found.refused)
        best = _of_pieces(judge, found, settings, best)
        if best.meets:
            return best
        off = miss(best.measures, judge.tolerance) if best.measures else 0.0
        out_of_reach = off > _IN_REACH and (found.way == "remeshed" or len(found.pieces) > _MANY)
    return _worthwhile(best, made, judge.tolerance)


def _worthwhile(pieces: Collision, hull: Collision, tolerance: float) -> Collision:
    """Of what misses the tolerance [m] the pieces, where they are so much nearer than the hull that they are
    worth what they cost a simulation; else the hull, which says how near they would be."""
    if pieces is hull or pieces.measures is None or hull.measures is None:
        return hull
    times = miss(hull.measures, tolerance) / miss(pieces.measures, tolerance)
    if times >= _WORTH:
        return pieces
    return hull.with_note(f"{len(pieces.pieces)} convex pieces, make: coacd, are {times:.2g} times as near")


def _of_pieces(judge: Judge, found: Decomposition, settings: ColliderSettings, best: Collision) -> Collision:
    """As few pieces as are near enough, or else what is nearest, `best` with them.

    A quick look finds the fewest that may be near enough, and measuring the fewest that are; both halve what
    is left, since pieces come nearer as they become more.
    """
    made: dict[int, tuple[Surface, ...]] = {}

    def hulls_of(most: int) -> tuple[Surface, ...]:
        if most not in made:
            made[most] = pieces(found, most, settings.max_vertices)
        return made[most]

    most = min(MOST_PIECES, len(found.pieces))
    low, high = min(_FEWEST, most), most
    while low < high:
        count = (low + high) // 2
        low, high = (count + 1, high) if judge.hopeless(hulls_of(count), points=_LOOK) else (low, count)
    enough: tuple[Surface, ...] = ()
    count, high = low, most
    while low <= high:
        hulls = hulls_of(count)
        if judge.near(hulls):
            enough, high = hulls, min(count, len(hulls)) - 1
        else:
            low = count + 1
        count = (low + high) // 2
    if enough:
        taken = plainer(judge, enough)
        measures = judge.measure(taken)
        return judge.collision(taken, measures, "pieces", miss(measures, judge.tolerance) <= 1)
    measures = judge.measure(hulls_of(most))
    if best.measures is None or miss(measures, judge.tolerance) < miss(best.measures, judge.tolerance):
        return judge.collision(hulls_of(most), measures, "pieces", meets=False)
    return best


def together(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
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
