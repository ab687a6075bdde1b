"""Makes convex pieces of a part of any shape with CoACD."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from linkwright.stages.formats.meshes.surface import Surface, join_surfaces
from linkwright.stages.mesh.collide.acceptance import Judge
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.cut_pieces import PieceCutter
from linkwright.stages.mesh.colliders import hull
from linkwright.stages.mesh.configuration.collider_settings import CoacdSettings, HullSettings
from linkwright.stages.mesh.decompose import NOT_CLOSED, coacd_parameters, convex_pieces


def make(surfaces: Sequence[Surface], settings: CoacdSettings) -> Collision:
    """Makes the convex hull, which stays the collider if CoACD fails later; no pieces for a flat part. A hull
    is marked as not near enough, so that `improve` follows."""
    hull_collider = hull.make(surfaces, HullSettings(settings.max_vertices))
    return replace(hull_collider, meets=not hull_collider.pieces)


def improve(surfaces: Sequence[Surface], settings: CoacdSettings, hull_collider: Collision) -> Collision:
    """Makes at most `MAX_PIECES` pieces; a surface that CoACD cannot take is cut by planes."""
    judge = Judge.of(join_surfaces(surfaces), settings.tolerance)
    if isinstance(judge, str):
        return hull_collider.with_note(judge)
    decomposition = convex_pieces(
        judge.surface, judge.tolerance, coacd_parameters(settings.effort, settings.coacd)
    )
    cutter = PieceCutter(judge, settings.max_vertices, settings.effort)
    if decomposition == NOT_CLOSED:
        pieces, note = cutter.cut().pieces, f"{NOT_CLOSED}: cut by planes"
    elif isinstance(decomposition, str):
        return hull_collider.with_note(decomposition)
    else:
        pieces, note = cutter.join(cutter.prepare(decomposition)).pieces, ""
    if not pieces:
        return hull_collider.with_note(note)
    return judge.collision(pieces, judge.measure(pieces), "pieces").with_note(note)
