"""Convex pieces of a part, whatever its shape, as CoACD decomposes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.colliders import hull
from stages.mesh.collision import Collision
from stages.mesh.decompose import (
    MOST_PIECES,
    DecomposeOptions,
    decomposition,
    pieces,
    read,
    search,
)
from stages.mesh.surface import Surface, joined
from stages.mesh.verdict import Judge
from stages.robot.guest import Guest


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """The convex hull, which stays where CoACD fails; none of what lies in a plane."""
    made = hull.make(surfaces, settings)
    return replace(made, meets=not made.pieces)


def improve(
    surfaces: Sequence[Surface], settings: ColliderSettings, made: Collision, guest: Guest
) -> Collision:
    """At most 16 pieces. DecompositionFailed where the guest fails."""
    judge = Judge.of(joined(surfaces), settings)
    if isinstance(judge, str):
        return made.with_note(judge)
    options = DecomposeOptions(judge.tolerance, search=search(settings.effort, settings.coacd))
    found = read(decomposition(judge.surface, options, guest))
    if found.refused:
        return made.with_note(found.refused)
    convex = pieces(found, MOST_PIECES, settings.max_vertices)
    return judge.collision(convex, judge.measure(convex), "pieces")
