"""Decompositions by a guest that is asked nothing else."""

from contextlib import closing
from typing import Any

from stages.mesh import decompose as rooms
from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.convex_hull import convex_hull
from stages.mesh.cut_pieces import PieceCutter
from stages.mesh.decompose import DecomposeOptions, decomposer, read
from stages.mesh.pieces import surface_of
from stages.mesh.surface import Surface
from stages.mesh.verdict import Judge
from stages.robot.errors import DecompositionFailed


def decomposition(surface: Surface, options: DecomposeOptions, **of_guest: Any) -> bytes:
    with closing(decomposer(**of_guest)) as guest:
        return rooms.decomposition(surface, options, guest)


def decompose(surface: Surface, options: DecomposeOptions, most_vertices: int = 64) -> tuple[Surface, ...]:
    """The convex pieces of a surface, joined, sorted. DecompositionFailed, with the reason, where there are
    none."""
    made = read(decomposition(surface, options))
    if made.refused:
        raise DecompositionFailed(made.refused)
    cutter = PieceCutter(judge(surface, options.tolerance), most_vertices)
    hulls = [hull for piece in made.pieces if (hull := convex_hull(piece))]
    return tuple(map(surface_of, cutter.join(cutter.parts_of(hulls)).pieces))


def cut(surface: Surface, tolerance: float | None = None, most_vertices: int = 64) -> tuple[Surface, ...]:
    """The convex pieces of a surface that is cut by planes."""
    return tuple(map(surface_of, PieceCutter(judge(surface, tolerance), most_vertices).cut().pieces))


def judge(surface: Surface, tolerance: float | None = None) -> Judge:
    """What pieces of a surface are judged by."""
    made = Judge.of(surface, ColliderSettings(tolerance=tolerance))
    assert isinstance(made, Judge)
    return made
