"""Decomposition of a part into convex pieces, in a guest process.

The guest makes more pieces than are wanted and the order in which to join them, and that is what is cached:
`pieces` takes from it as many as are asked for, at no cost, so trying 8 pieces and then 16 decomposes once.

CoACD 1.0.14 makes the pieces, since it is better than miniacd 0.1.5 with its threshold 0.1. Measured on 44
parts: those of so101 and open_duck_mini whose hull is at least 10 % larger than they, simplified by
manifold3d 3.5.4, and their pieces joined as here:

| | CPU s in all | the longest | failed | within the tolerance in 16 pieces | in 8 | extra volume in 16 |
| --- | --- | --- | --- | --- | --- | --- |
| CoACD, effort normal | 123 | 13 | 0 | 40 | 29 | 11 % |
| miniacd | 213 | 55 | 3 | 15 | 12 | 38 % |
"""

from __future__ import annotations

import numpy as np

from stages.mesh.convex_hull import convex_hull
from stages.mesh.decompose.ask import BOUNDS, decomposer, decomposition, decomposition_key
from stages.mesh.decompose.cost import estimated_cost
from stages.mesh.decompose.joining import groups
from stages.mesh.decompose.pool import Making, side_by_side
from stages.mesh.decompose.seams import containing
from stages.mesh.decompose.sectors import hole
from stages.mesh.decompose.wire import Decomposition, read
from stages.mesh.decompose_options import EFFORTS, MOST_PIECES, DecomposeOptions, Search, search
from stages.mesh.fit import capped_hull
from stages.mesh.surface import Surface

__all__ = [
    "BOUNDS",
    "EFFORTS",
    "MOST_PIECES",
    "DecomposeOptions",
    "Decomposition",
    "Making",
    "Search",
    "decomposer",
    "decomposition",
    "decomposition_key",
    "estimated_cost",
    "hole",
    "pieces",
    "read",
    "search",
    "side_by_side",
]


def pieces(made: Decomposition, most: int, most_vertices: int = 64) -> tuple[Surface, ...]:
    """At most so many convex pieces, sorted; fewer where joining them adds no volume to speak of.

    A piece with too many vertices becomes one with fewer that contains it, so that no seam opens; a piece
    that is alone the one of least error.
    """
    joined = groups(len(made.pieces), made.joinings, most, made.volume)
    hulls = [convex_hull(np.concatenate([made.pieces[one] for one in group])) for group in joined]
    capped = capped_hull if len(joined) == 1 else containing
    plain = (capped(hull, most_vertices) for hull in hulls if hull)
    return tuple(sorted((hull for hull in plain if hull), key=lambda hull: hull.vertices.tobytes()))
