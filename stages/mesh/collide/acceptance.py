"""Whether a collider is near enough to its part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from linkwright.stages.formats.meshes.surface import Surface, joined
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import default_tolerance
from linkwright.stages.mesh.fit.score import MOST_OF_TOLERANCE
from linkwright.stages.mesh.measure import FEW, Measures, Target, hopeless, measure, near
from linkwright.stages.mesh.surfaces.clean import clean
from linkwright.stages.mesh.surfaces.pieces import Piece


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """A part, cleaned, and how near a collider has to be to it.

    `surface`: what it collides with, without cavities and what is flat; `tolerance` [m]; `extra_volume`:
    the share of the part's volume that one piece for the whole part may add.
    """

    surface: Surface
    target: Target
    tolerance: float
    extra_volume: float

    @staticmethod
    def of(surface: Surface, tolerance: float | None = None, extra_volume: float = 0.0) -> Judge | str:
        """Of any triangles; why there is nothing to judge, in words, where that is so. `tolerance` [m]: None
        for that of its size."""
        bodies = clean(surface).bodies()
        if not bodies:
            return "the part is flat"
        solid = joined(bodies)
        try:
            target = Target.of(solid)
        except ValueError as error:
            return str(error)
        tolerance = default_tolerance(solid.diagonal) if tolerance is None else tolerance
        # Within the tolerance a collider may be larger than the part all around it: of a thin part that is
        # a large share of its volume.
        volume = max(target.volume, 0.0)
        skin = solid.area() * tolerance
        allowed = extra_volume * (volume + skin) / volume if volume > 0 else float("inf")
        return Judge(solid, target, tolerance, allowed)

    def hopeless(self, pieces: Sequence[Piece], tolerances: float = 1.0, points: int = FEW) -> bool:
        """A quick no: whether so many points say already that the pieces are too far off, by so many times
        the tolerance."""
        return hopeless(self.target, pieces, tolerances * self.tolerance, points)

    def measure(self, pieces: Sequence[Piece], protrusion: tuple[float, float] | None = None) -> Measures:
        return measure(self.target, pieces, protrusion)

    def near(self, pieces: Sequence[Piece]) -> bool:
        """Whether pieces are near enough."""
        return near(self.target, pieces, self.tolerance, MOST_OF_TOLERANCE * self.tolerance)

    def collision(
        self, pieces: Sequence[Piece], measures: Measures, rung: str, meets: bool = True
    ) -> Collision:
        """Pieces that were judged."""
        faces = len(self.surface.triangles)
        return Collision(tuple(pieces), faces, measures, rung, self.tolerance, meets)

    def whole_meets(self, measures: Measures) -> bool:
        """Whether one piece for the whole part is near enough."""
        extra = float("inf") if measures.extra is None else measures.extra
        return miss(measures, self.tolerance) <= 1 and extra <= self.extra_volume


def measured(made: Collision, surfaces: Sequence[Surface], tolerance: float | None) -> Collision:
    """A collider that was made without a look at its measures, with them."""
    judge = Judge.of(joined(surfaces), tolerance)
    if isinstance(judge, str) or not made.pieces:
        return made
    return judge.collision(made.pieces, judge.measure(made.pieces), made.rung).with_note(made.note)


def miss(measures: Measures, tolerance: float) -> float:
    """How many times the tolerance [m] a collider is off: at most 1 where it meets it.

    95 % of its surface may stand out by the tolerance and all of it by three times as much; no point of the
    part may be further outside of it than the tolerance.
    """
    return max(
        measures.protrusion_p95 / tolerance,
        measures.protrusion_max / (MOST_OF_TOLERANCE * tolerance),
        measures.bareness_max / tolerance,
    )
