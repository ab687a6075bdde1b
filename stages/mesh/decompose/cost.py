"""What a decomposition will cost, by what is known before it, never by a clock."""

from __future__ import annotations

import math

from stages.mesh.decompose_options import DecomposeOptions, Search

_START = 0.5
"""CPU seconds of a guest that has little to do."""

_OF_READING = 1e-5
"""CPU seconds for each triangle of the mesh."""

_KEPT = 500
_KEPT_OF_FACES = 0.15
_MOST_KEPT = 2500
"""How many triangles the simplification keeps: about so many, and so many of all, and rarely more."""

_OF_SEARCH = 2.2e-3
"""CPU seconds for each triangle that is kept."""


_OF_OPEN = 4.5
"""How many times as long a part takes that is not closed: a surface is laid around it first."""


def estimated_cost(faces: int, options: DecomposeOptions, closed: bool = True) -> float:
    """CPU seconds that a part of so many triangles takes, about.

    Fitted to 44 closed parts of two robots, on one processor of 2.5 GHz: they took 0.8 times as long in all,
    four of five between 0.3 and 1.6 times, the worst 6.5 times; and to ten of a third that are not closed.
    The time also grows with the iterations of the search and, since each of them looks ahead, with about the
    square root of its depth and of its nodes.
    """
    normal, chosen = Search(), options.search
    effort = chosen.mcts_iterations / normal.mcts_iterations
    effort *= math.sqrt(chosen.mcts_max_depth / normal.mcts_max_depth)
    effort *= math.sqrt(chosen.mcts_nodes / normal.mcts_nodes)
    kept = min(faces, _KEPT + _KEPT_OF_FACES * faces, _MOST_KEPT)
    cost = _START + _OF_READING * faces + _OF_SEARCH * effort * kept
    return cost if closed else _OF_OPEN * cost
