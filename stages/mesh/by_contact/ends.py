"""Cuts the colliders of links that meet the world until they are within the link's tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface, join_surfaces
from linkwright.stages.mesh.collide.acceptance import Judge
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings, default_tolerance
from linkwright.stages.mesh.cut import planes
from linkwright.stages.mesh.cut.chunk import Chunk, hull_surface, qhull
from linkwright.stages.mesh.cut.cutting import cut_by_plane, cut_costliest
from linkwright.stages.mesh.cut.outside import Protrusion, ReachableSurface, SampledPiece
from linkwright.stages.robot.model.geometry import Measures

MAX_PIECES = 12
"""Largest number of pieces of a link that meets the world."""

_MEASURED_PLANES = 3, 6
"""Numbers of planes for each cut that are compared by the pieces they make: first three, then six if three
do not lead to the tolerance."""

_PATIENCE, _MIN_VAIN_SHARE = 5, 0.95
"""Cutting ends after five cuts in a row that left more than 95 % of the protrusion before them."""

_MIN_HOPELESS_TOLERANCES = 1.5
"""If all states so far stand out by more than this many tolerances, the tolerance counts as out of reach:
cutting may end early, and more planes are not tried."""

_MAX_RATIO_TO_BEST = 1.15
"""If no state is within the tolerance, the first state is used whose protrusion is at most this many times
that of the best."""


_State = tuple[Protrusion, list[Chunk]]
"""How far the pieces of a collider stand out of the link, and the pieces."""


@dataclass(frozen=True, slots=True, eq=False)
class End:
    """How far the collider of a link that meets the world stands out of the link's reachable surface."""

    tolerance: float
    """Tolerance of the link [m]."""
    p95: float
    """Distance [m] that 95 % of the outer surface does not exceed."""
    most: float
    """Largest distance [m] of all of the outer surface."""
    measures: Measures | None
    """Measures of the whole collider; None if the link's mesh is too tangled."""

    @property
    def meets(self) -> bool:
        """Whether the collider is within the tolerance."""
        return self.p95 <= self.tolerance


def fit_end(
    surface: Surface, starts: Sequence[Sequence[Chunk]], settings: ContactSettings
) -> tuple[list[Chunk], End]:
    """Returns the pieces of a link that meets the world, and how near they are to the link."""
    tolerance = default_tolerance(surface.diagonal)
    reachable = ReachableSurface.of(surface, tolerance)
    out, chunks = _fit(starts, reachable, tolerance, settings.max_vertices)
    judge = Judge.of(surface)
    measures = None
    if isinstance(judge, Judge):
        measures = judge.measure([chunk.piece for chunk in chunks], (out.p95, out.most))
    return chunks, End(tolerance, out.p95, out.most, measures)


def _fit(
    starts: Sequence[Sequence[Chunk]], reachable: ReachableSurface, tolerance: float, max_vertices: int
) -> _State:
    """Returns pieces that stand out of the link by at most `tolerance` [m] with 95 % of their outer surface,
    cut from the first of the `starts` that leads to such pieces; if no start does, the best pieces found."""
    best: _State | None = None
    for plane_count, start in product(_MEASURED_PLANES, starts):
        if best and plane_count != _MEASURED_PLANES[0] and best[0].p95 > _MIN_HOPELESS_TOLERANCES * tolerance:
            break
        state = _cut(start, reachable, tolerance, max_vertices, plane_count)
        if best is None or state[0].p95 < best[0].p95:
            best = state
        if state[0].p95 <= tolerance:
            break
    assert best is not None  # there is a start
    return best


def _cut(
    chunks: Sequence[Chunk],
    reachable: ReachableSurface,
    tolerance: float,
    max_vertices: int,
    plane_count: int,
) -> _State:
    """Cuts again and again the piece with the largest area outside the tolerance; returns the pieces, and how
    far they stand out."""
    states: list[_State] = []
    sampled: dict[Chunk, SampledPiece] = {}
    faces = planes.flat_faces(join_surfaces([chunk.surface for chunk in chunks]))

    def halves(chunk: Chunk) -> list[Chunk]:
        return [] if chunk.is_final else _halves(chunk, faces, reachable, max_vertices, plane_count)

    for current in cut_costliest(chunks, lambda _: states[-1][0].far, halves):
        for chunk in current:
            if chunk not in sampled:
                sampled[chunk] = reachable.sampled(chunk.piece)
        out = reachable.protrusion([sampled[chunk] for chunk in current])
        states.append((out, current))
        if (
            out.p95 <= tolerance
            or len(current) >= MAX_PIECES
            or _stalls([out.p95 for out, _ in states], tolerance)
        ):
            break
    least_p95 = min(out.p95 for out, _ in states)
    largest_p95 = tolerance if least_p95 <= tolerance else _MAX_RATIO_TO_BEST * least_p95
    return next(state for state in states if state[0].p95 <= largest_p95)


def _stalls(p95s: Sequence[float], tolerance: float) -> bool:
    """Tells whether the tolerance is out of reach, and the last cuts did not help."""
    if len(p95s) <= _PATIENCE or min(p95s) < _MIN_HOPELESS_TOLERANCES * tolerance:
        return False
    return min(p95s[-_PATIENCE:]) > _MIN_VAIN_SHARE * min(p95s[:-_PATIENCE])


def _halves(
    chunk: Chunk, faces: list[planes.Plane], reachable: ReachableSurface, max_vertices: int, plane_count: int
) -> list[Chunk]:
    """Cuts a piece in two that stand out as little as possible. Only the `plane_count` planes that leave the
    least volume are compared; the result is empty if no plane reduces the volume."""
    cloud = chunk.cloud()
    axes = planes.axes_of(chunk.surface)
    candidates = planes.crossing([*faces, *planes.through(axes, cloud)], cloud)

    def roughly(*sides: Points) -> float:
        volume = sum(hull.volume for side in sides if (hull := qhull(side)) is not None)
        return round(float(volume), 12)

    best: tuple[float, list[tuple[Surface, Surface]]] = np.inf, []
    for volume, (normal, height) in planes.ranked(candidates, cloud, roughly):
        if not plane_count or volume >= chunk.volume:
            break
        sides = [side for side in cut_by_plane(chunk.surface, normal, height) if len(side.triangles)]
        hulls = [hull_surface(side.vertices) for side in sides]
        sides_and_hulls = [(side, hull) for side, hull in zip(sides, hulls, strict=True) if hull is not None]
        if len(sides_and_hulls) < len(sides):
            continue  # a flat side would be bare
        plane_count -= 1
        out = round(sum(reachable.sampled(hull).volume for _, hull in sides_and_hulls), 15)
        if out < best[0]:
            best = out, sides_and_hulls
    halves = [Chunk.of_hull(*side_and_hull, max_vertices, chunk.collider_index) for side_and_hull in best[1]]
    pieces = [half for half in halves if half is not None]
    return pieces if len(pieces) == len(halves) else []
