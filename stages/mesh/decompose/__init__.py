"""Decomposition of a part into convex pieces, in a guest process.

The guest makes more pieces than are wanted and the order in which to join them, and that is what is cached:
`pieces` takes from it as many as are asked for, at no cost, so trying 8 pieces and then 16 decomposes once.
"""

from __future__ import annotations

import numpy as np

from stages.mesh.convex_hull import convex_hull
from stages.mesh.decompose import wire
from stages.mesh.decompose.ask import BOUNDS, Guest, decomposition, decomposition_key
from stages.mesh.decompose.joining import groups
from stages.mesh.decompose.options import EFFORTS, DecomposeOptions, Search, search
from stages.mesh.decompose.wire import Decomposition, read
from stages.mesh.surface import Surface
from stages.robot.errors import DecompositionFailed

__all__ = [
    "BOUNDS",
    "EFFORTS",
    "DecomposeOptions",
    "Decomposition",
    "Guest",
    "Search",
    "decompose",
    "decomposition",
    "decomposition_key",
    "pieces",
    "read",
    "search",
]


def decompose(surface: Surface, options: DecomposeOptions, by: Guest | None = None) -> tuple[Surface, ...]:
    """The convex pieces of a surface, sorted. DecompositionFailed, with the reason, where there are none."""
    made = wire.read(decomposition(surface, options, by))
    if made.refused:
        raise DecompositionFailed(made.refused)
    return pieces(made, options.most_pieces)


def pieces(made: Decomposition, most: int) -> tuple[Surface, ...]:
    """At most so many convex pieces, sorted; fewer where joining them adds no volume to speak of."""
    joined = groups(len(made.pieces), made.joinings, most, made.volume)
    hulls = [convex_hull(np.concatenate([made.pieces[one] for one in group])) for group in joined]
    return tuple(sorted((hull for hull in hulls if hull), key=lambda hull: hull.vertices.tobytes()))
