"""Convex pieces of a part, whatever its shape, as CoACD decomposes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from linkwright.stages.formats.meshes.surface import Surface, joined
from linkwright.stages.mesh.collide.acceptance import Judge
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.cut_pieces import PieceCutter
from linkwright.stages.mesh.colliders import hull
from linkwright.stages.mesh.configuration.collider_settings import CoacdSettings, HullSettings
from linkwright.stages.mesh.decompose import NOT_CLOSED, decomposed, search


def make(surfaces: Sequence[Surface], settings: CoacdSettings) -> Collision:
    """The convex hull, which stays where CoACD fails; none of what lies in a plane."""
    made = hull.make(surfaces, HullSettings(settings.max_vertices))
    return replace(made, meets=not made.pieces)


def improve(surfaces: Sequence[Surface], settings: CoacdSettings, made: Collision) -> Collision:
    """At most 16 pieces; what is not closed is cut by planes."""
    judge = Judge.of(joined(surfaces), settings.tolerance)
    if isinstance(judge, str):
        return made.with_note(judge)
    found = decomposed(judge.surface, judge.tolerance, search(settings.effort, settings.coacd))
    cutter = PieceCutter(judge, settings.max_vertices, settings.effort)
    if found == NOT_CLOSED:
        pieces, note = cutter.cut().pieces, f"{NOT_CLOSED}: cut by planes"
    elif isinstance(found, str):
        return made.with_note(found)
    else:
        pieces, note = cutter.join(cutter.parts_of(found)).pieces, ""
    if not pieces:
        return made.with_note(note)
    return judge.collision(pieces, judge.measure(pieces), "pieces").with_note(note)
