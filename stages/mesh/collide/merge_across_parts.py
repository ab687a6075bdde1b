"""Fewer convex pieces for several parts of a link: pieces of different parts become one where they may.

Two halves of a case, or a motor in its holder, are each well within the tolerance in eight pieces, and nearly
as well together. What a step of a simulation costs is the number of pieces.
"""

from __future__ import annotations

from collections.abc import Sequence

from linkwright.stages.formats.meshes.surface import Surface, joined
from linkwright.stages.mesh.collide.acceptance import Judge, miss
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.cut_pieces import PieceCutter
from linkwright.stages.mesh.configuration.collider_settings import LadderSettings
from linkwright.stages.mesh.surfaces.pieces import Piece

_WORTH = 0.9
"""Pieces are joined where so small a share of them is near enough."""

MANY = 12
"""Fewer pieces of a link stay with their parts."""


def across(surfaces: Sequence[Surface], pieces: Sequence[Piece], settings: LadderSettings) -> Collision:
    """Of parts and the pieces of all their colliders, in one frame: as few pieces as are near enough to the
    parts, by the least of their tolerances; none where that saves next to nothing. A joined piece holds those
    that it is made of, so no part is left barer than before."""
    least = min(map(settings.tolerance_of, surfaces))
    judge = Judge.of(joined(surfaces), least)
    if isinstance(judge, str):
        return Collision(meets=False)
    cutter = PieceCutter(judge, settings.max_vertices)
    fewer = cutter.join(cutter.parts_of(pieces), len(pieces)).pieces
    if len(fewer) > _WORTH * len(pieces):
        return Collision(meets=False)
    measures = judge.measure(fewer)
    return judge.collision(fewer, measures, "pieces", miss(measures, judge.tolerance) <= 1)
