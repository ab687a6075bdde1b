"""Decompositions by a guest that is asked nothing else."""

from contextlib import closing
from typing import Any

from stages.mesh import decompose as rooms
from stages.mesh.decompose import DecomposeOptions, decomposer, pieces, read
from stages.mesh.surface import Surface
from stages.robot.errors import DecompositionFailed


def decomposition(surface: Surface, options: DecomposeOptions, **of_guest: Any) -> bytes:
    with closing(decomposer(**of_guest)) as guest:
        return rooms.decomposition(surface, options, guest)


def decompose(surface: Surface, options: DecomposeOptions) -> tuple[Surface, ...]:
    """The convex pieces of a surface, sorted. DecompositionFailed, with the reason, where there are none."""
    made = read(decomposition(surface, options))
    if made.refused:
        raise DecompositionFailed(made.refused)
    return pieces(made, options.most_pieces, options.most_vertices)
