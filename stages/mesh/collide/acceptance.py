"""Decides whether a collider is near enough to its part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from linkwright.stages.formats.meshes.surface import Surface, join_surfaces
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import default_tolerance
from linkwright.stages.mesh.fit.score import MAX_PROTRUSION_TOLERANCES
from linkwright.stages.mesh.measure import (
    QUICK_SAMPLE_COUNT,
    MeasuredPart,
    Measures,
    is_hopeless,
    is_near,
    measure,
)
from linkwright.stages.mesh.surfaces.clean import clean
from linkwright.stages.mesh.surfaces.pieces import Piece


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """A cleaned part, and how near a collider must be to it."""

    surface: Surface
    """Surface of the part, without cavities and flat portions."""
    target: MeasuredPart
    tolerance: float
    """Tolerance [m]."""
    extra_volume: float
    """Largest volume that a single piece for the whole part may add, as a share of the part's volume."""

    @staticmethod
    def of(surface: Surface, tolerance: float | None = None, extra_volume: float = 0.0) -> Judge | str:
        """Returns the judge of any triangles, or the reason in words why there is nothing to judge.
        `tolerance` [m]: None for the default of the part's size."""
        bodies = clean(surface).bodies()
        if not bodies:
            return "the part is flat"
        solid = join_surfaces(bodies)
        try:
            target = MeasuredPart.of(solid)
        except ValueError as error:
            return str(error)
        tolerance = default_tolerance(solid.diagonal) if tolerance is None else tolerance
        # A collider may be larger than the part by the tolerance all around, and for a thin part that layer
        # is a large share of the volume.
        volume = max(target.volume, 0.0)
        skin = solid.area() * tolerance
        allowed = extra_volume * (volume + skin) / volume if volume > 0 else float("inf")
        return Judge(solid, target, tolerance, allowed)

    def is_hopeless(
        self, pieces: Sequence[Piece], tolerances: float = 1.0, points: int = QUICK_SAMPLE_COUNT
    ) -> bool:
        """Tells whether a sample of `points` already shows that the pieces are off by more than this number
        of `tolerances`."""
        return is_hopeless(self.target, pieces, tolerances * self.tolerance, points)

    def measure(self, pieces: Sequence[Piece], protrusion: tuple[float, float] | None = None) -> Measures:
        return measure(self.target, pieces, protrusion)

    def is_near(self, pieces: Sequence[Piece]) -> bool:
        """Tells whether pieces are near enough."""
        return is_near(self.target, pieces, self.tolerance, MAX_PROTRUSION_TOLERANCES * self.tolerance)

    def collision(
        self, pieces: Sequence[Piece], measures: Measures, rung: str, meets: bool = True
    ) -> Collision:
        """Returns the collider that consists of these pieces, with their measures."""
        faces = len(self.surface.triangles)
        return Collision(tuple(pieces), faces, measures, rung, self.tolerance, meets)

    def whole_meets(self, measures: Measures) -> bool:
        """Tells whether a single piece for the whole part is near enough."""
        extra = float("inf") if measures.extra is None else measures.extra
        return miss(measures, self.tolerance) <= 1 and extra <= self.extra_volume


def with_measures(collision: Collision, surfaces: Sequence[Surface], tolerance: float | None) -> Collision:
    """Returns the collider with measures against its part. `surfaces`: surfaces of the part; `tolerance` [m]:
    None for the default. A flat part cannot be measured: the collider stays as it is."""
    judge = Judge.of(join_surfaces(surfaces), tolerance)
    if isinstance(judge, str) or not collision.pieces:
        return collision
    return judge.collision(collision.pieces, judge.measure(collision.pieces), collision.rung).with_note(
        collision.note
    )


def miss(measures: Measures, tolerance: float) -> float:
    """Returns by how many tolerances [m] a collider is off; at most 1 if it meets the tolerance.

    95 % of the collider's surface may stand out by the tolerance, and all of it by three times as much; no
    point of the part may be further outside of the collider than the tolerance.
    """
    return max(
        measures.protrusion_p95 / tolerance,
        measures.protrusion_max / (MAX_PROTRUSION_TOLERANCES * tolerance),
        measures.bareness_max / tolerance,
    )
