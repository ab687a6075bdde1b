"""What a decomposition will cost, by what is known before it: an upper estimate, never a clock."""

from __future__ import annotations

import math

from stages.mesh.decompose_options import DecomposeOptions, Search

_START = 0.5
"""CPU seconds of a guest that has nothing to do."""

_OF_READING = 1e-5
"""CPU seconds for each triangle of the mesh."""

_MOST_LEFT = 4000
_OF_SEARCH = 2.5e-3


def estimated_cost(faces: int, options: DecomposeOptions) -> float:
    """CPU seconds that a part of so many triangles takes, on a processor of 2020; most take less.

    Fitted to the parts of three robots with CoACD 1.0.14 and manifold3d 3.5.4. The time grows with the
    triangles that the simplification leaves, with the iterations of the search and, since each of them also
    looks ahead, with about the square root of its depth and of its nodes.
    """
    normal, chosen = Search(), options.search
    effort = chosen.mcts_iterations / normal.mcts_iterations
    effort *= math.sqrt(chosen.mcts_max_depth / normal.mcts_max_depth)
    effort *= math.sqrt(chosen.mcts_nodes / normal.mcts_nodes)
    return _START + _OF_READING * faces + _OF_SEARCH * effort * min(faces, _MOST_LEFT)
