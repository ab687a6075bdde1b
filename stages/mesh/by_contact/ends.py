"""Links that meet the world: their pieces are cut until the collider is within the link's tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface, joined
from linkwright.stages.mesh.collide.acceptance import Judge
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings, default_tolerance
from linkwright.stages.mesh.cut import planes
from linkwright.stages.mesh.cut.cutting import cut, cuts
from linkwright.stages.mesh.cut.outside import Outside, Sampled, StandingOut
from linkwright.stages.mesh.cut.piece import Chunk, hull_of, whole_hull
from linkwright.stages.robot.model.geometry import Measures

MOST = 12
"""Pieces of a link that meets the world."""

_MEASURED = 3, 6
"""Of how many planes the pieces are measured: where the best of three leads away from the tolerance, the best
of six may not."""

_PATIENCE, _BETTER = 5, 0.95
"""Cutting ends after five cuts in a row that left more than 95 % of what stood out before them."""

_OUT_OF_REACH = 1.5
"""Cutting ends early, and more planes are not measured, only where all states so far stand out by more than
1.5 times the tolerance."""

_WORTH = 1.15
"""Where no state is within the tolerance, the first is taken that stands out at most 1.15 times as far as the
best."""


_State = tuple[StandingOut, list[Chunk]]
"""How far pieces stand out, and the pieces."""


@dataclass(frozen=True, slots=True, eq=False)
class End:
    """How far [m] the colliders of a link that meets the world stand out of what can be reached of it: 95 %
    of their outer surface, and all of it. `measures`: of all of them together, None where the link's mesh is
    too tangled."""

    tolerance: float
    p95: float
    most: float
    measures: Measures | None

    @property
    def meets(self) -> bool:
        """Whether it is within the tolerance."""
        return self.p95 <= self.tolerance


def fitted_end(
    surface: Surface, starts: Sequence[Sequence[Chunk]], settings: ContactSettings
) -> tuple[list[Chunk], End]:
    """The pieces of a link that meets the world, and how near they are to it."""
    tolerance = default_tolerance(surface.diagonal)
    outside = Outside.of(surface, tolerance)
    out, chunks = _fitted(starts, outside, tolerance, settings.max_vertices)
    judge = Judge.of(surface)
    measures = None
    if isinstance(judge, Judge):
        measures = judge.measure([chunk.piece for chunk in chunks], (out.p95, out.most))
    return chunks, End(tolerance, out.p95, out.most, measures)


def _fitted(
    starts: Sequence[Sequence[Chunk]], outside: Outside, tolerance: float, max_vertices: int
) -> _State:
    """Pieces of which 95 % of the outer surface stand out of the link by at most `tolerance` [m]: those that
    come of cutting the first of the `starts` that leads there, else the best of all."""
    best: _State | None = None
    for measured, start in product(_MEASURED, starts):
        if best and measured != _MEASURED[0] and best[0].p95 > _OUT_OF_REACH * tolerance:
            break
        found = _cut(start, outside, tolerance, max_vertices, measured)
        if best is None or found[0].p95 < best[0].p95:
            best = found
        if found[0].p95 <= tolerance:
            break
    assert best is not None  # there is a start
    return best


def _cut(
    chunks: Sequence[Chunk], outside: Outside, tolerance: float, max_vertices: int, measured: int
) -> _State:
    """Pieces, and how far they stand out. The piece with most area out of the tolerance is cut, again and
    again."""
    tried: list[_State] = []
    sampled: dict[Chunk, Sampled] = {}
    faces = planes.flat_faces(joined([chunk.surface for chunk in chunks]))

    def halves(chunk: Chunk) -> list[Chunk]:
        return [] if chunk.stays else _halves(chunk, faces, outside, max_vertices, measured)

    for now in cuts(chunks, lambda _: tried[-1][0].far, halves):
        for chunk in now:
            if chunk not in sampled:
                sampled[chunk] = outside.sampled(chunk.piece)
        out = outside.standing_out([sampled[chunk] for chunk in now])
        tried.append((out, now))
        if out.p95 <= tolerance or len(now) >= MOST or _stalls([out.p95 for out, _ in tried], tolerance):
            break
    least = min(out.p95 for out, _ in tried)
    enough = tolerance if least <= tolerance else _WORTH * least
    return next(state for state in tried if state[0].p95 <= enough)


def _stalls(found: Sequence[float], tolerance: float) -> bool:
    """Whether the tolerance is out of reach, and the last cuts brought nothing."""
    if len(found) <= _PATIENCE or min(found) < _OUT_OF_REACH * tolerance:
        return False
    return min(found[-_PATIENCE:]) > _BETTER * min(found[:-_PATIENCE])


def _halves(
    chunk: Chunk, faces: list[planes.Plane], outside: Outside, max_vertices: int, measured: int
) -> list[Chunk]:
    """The two pieces that stand out least, by as many planes as are `measured`, those that leave the least
    volume; none where every plane leaves as much."""
    cloud = chunk.cloud()
    axes = planes.axes_of(chunk.surface)
    every = planes.crossing(iter([*faces, *planes.through(axes, cloud)]), cloud)

    def roughly(*sides: Points) -> float:
        volume = sum(hull.volume for side in sides if (hull := hull_of(side)) is not None)
        return round(float(volume), 12)

    best: tuple[float, list[tuple[Surface, Surface]]] = np.inf, []
    for volume, (normal, height) in planes.ranked(every, cloud, roughly):
        if not measured or volume >= chunk.volume:
            break
        sides = [side for side in cut(chunk.surface, normal, height) if len(side.triangles)]
        hulls = [whole_hull(side.vertices) for side in sides]
        made = [(side, hull) for side, hull in zip(sides, hulls, strict=True) if hull is not None]
        if len(made) < len(sides):
            continue  # a flat side would be bare
        measured -= 1
        out = round(sum(outside.sampled(hull).volume for _, hull in made), 15)
        if out < best[0]:
            best = out, made
    halves = [Chunk.around(*both, max_vertices, chunk.group) for both in best[1]]
    found = [half for half in halves if half is not None]
    return found if len(found) == len(halves) else []
