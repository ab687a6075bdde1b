"""Convex pieces of every part, whatever its shape, as CoACD decomposes it."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import partial

from stages.mesh import mesh_file
from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.decompose import (
    MOST_PIECES,
    DecomposeOptions,
    Guest,
    Making,
    decomposition,
    pieces,
    read,
    search,
    side_by_side,
)
from stages.mesh.link_mesh import Collider
from stages.mesh.surface import Surface
from stages.robot.errors import DecompositionFailed


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> tuple[Collider, ...]:
    """At most 16 pieces a part; none of a part that is flat. DecompositionFailed where CoACD fails."""
    makings = [
        Making(f"part {number}", partial(_decomposition, surface, settings))
        for number, surface in enumerate(surfaces, 1)
    ]
    found: list[Collider] = []
    for made in side_by_side(makings):
        if isinstance(made, DecompositionFailed):
            raise made
        result = read(made)
        if not result.refused:
            found += map(mesh_file.collider, pieces(result, MOST_PIECES, settings.max_vertices))
    return tuple(found)


def _decomposition(surface: Surface, settings: ColliderSettings, halt: threading.Event) -> bytes:
    options = DecomposeOptions(settings.tolerance_of([surface]), search=search("normal", settings.coacd))
    return decomposition(surface, options, Guest(halt=halt))
