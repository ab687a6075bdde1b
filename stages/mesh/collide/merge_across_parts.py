"""Joins convex pieces of different parts of a link if the result is near enough to the parts.

For two halves of a case, or a motor in its holder, eight pieces each are well within the tolerance, but so
are, nearly, eight pieces for both together. The number of pieces decides how long a step of a simulation
takes.
"""

from __future__ import annotations

from collections.abc import Sequence

from linkwright.stages.formats.meshes.surface import Surface, join_surfaces
from linkwright.stages.mesh.collide.acceptance import Judge, miss
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.cut_pieces import PieceCutter
from linkwright.stages.mesh.configuration.collider_settings import LadderSettings
from linkwright.stages.mesh.surfaces.pieces import Piece

_MAX_SHARE_LEFT = 0.9
"""Largest share of the pieces that may be left after joining; with more, joining is not worth it."""

MIN_PIECES = 12
"""Smallest number of pieces of a link that are joined."""


def merge_across_parts(
    surfaces: Sequence[Surface], pieces: Sequence[Piece], settings: LadderSettings
) -> Collision:
    """Returns the fewest pieces that are near enough to the parts by the smallest of their tolerances; no
    pieces if that saves less than a tenth of them. `surfaces`: the parts; `pieces`: the pieces of all their
    colliders, in the same frame. A joined piece contains the pieces from which it is made, so that no part is
    left barer than before."""
    smallest_tolerance = min(map(settings.tolerance_of, surfaces))
    judge = Judge.of(join_surfaces(surfaces), smallest_tolerance)
    if isinstance(judge, str):
        return Collision(meets=False)
    cutter = PieceCutter(judge, settings.max_vertices)
    joined_pieces = cutter.join(cutter.prepare(pieces), len(pieces)).pieces
    if len(joined_pieces) > _MAX_SHARE_LEFT * len(pieces):
        return Collision(meets=False)
    measures = judge.measure(joined_pieces)
    return judge.collision(joined_pieces, measures, "pieces", miss(measures, judge.tolerance) <= 1)
