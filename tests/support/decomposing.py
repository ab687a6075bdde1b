"""Colliders that are cut, or decomposed, by a guest that is asked nothing else or by none."""

from contextlib import closing

from linkwright.stages.mesh.collide import improvement
from linkwright.stages.mesh.collide.acceptance import Judge
from linkwright.stages.mesh.collide.cut_pieces import PieceCutter
from linkwright.stages.mesh.collide.improvement import Improvement, helper
from linkwright.stages.mesh.colliders import coacd
from linkwright.stages.mesh.configuration.collider_settings import CoacdSettings
from linkwright.stages.mesh.decompose import CoacdParameters, convex_pieces
from linkwright.stages.mesh.surfaces.pieces import surface_of
from linkwright.stages.robot.errors import DecompositionFailed

DEFAULT = CoacdParameters()


def task(surface, tolerance=0.001, **options):
    """To decompose a surface by CoACD with these options."""
    settings = CoacdSettings(tolerance=tolerance, **options)
    return Improvement("coacd", [surface], settings, coacd.make([surface], settings))


def improved(work, **of_guest):
    """By a guest that is asked nothing else."""
    with closing(helper(**of_guest)) as guest:
        return improvement.improved(work, guest)


def decompose(surface, tolerance, most_vertices=64, parameters=DEFAULT):
    """The convex pieces of a surface, joined, sorted. DecompositionFailed, with the reason, where there are
    none."""
    made = convex_pieces(surface, tolerance, parameters)
    if isinstance(made, str):
        raise DecompositionFailed(made)
    cutter = PieceCutter(judge(surface, tolerance), most_vertices)
    return tuple(map(surface_of, cutter.join(cutter.prepare(made)).pieces))


def cut(surface, tolerance=None, most_vertices=64):
    """The convex pieces of a surface that is cut by planes."""
    return tuple(map(surface_of, PieceCutter(judge(surface, tolerance), most_vertices).cut().pieces))


def judge(surface, tolerance=None):
    """What pieces of a surface are judged by."""
    made = Judge.of(surface, tolerance)
    assert isinstance(made, Judge)
    return made
