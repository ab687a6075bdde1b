"""Reads the name of one mate as onshape-to-robot does: a joint, its direction, its limits."""

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from linkwright.stages.graph.onshape.assembly import Assembly, Mate, MateRelation, Path
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import frozen
from linkwright.stages.robot.text.names import legal

DOF, CLOSING, FRAME, FIX = "dof_", "closing_", "frame_", "fix_"
INVERTED = frozenset({"inv", "inverted"})
ENDLESS = frozenset({"wheel", "continuous"})

FLIP = frozen(np.diag([1.0, -1.0, -1.0, 1.0]))
"""Half a turn about x: of a mate with both frames so turned all but its slide along x counts backwards."""

_FLIPPED = {
    f"limit{side}{end}": f"limit{side}{other}"
    for side in ("AxialZ", "Y", "Z")
    for end, other in (("Min", "Max"), ("Max", "Min"))
}


def rest(mate: Mate) -> str:
    """A mate's name without its prefix."""
    return mate.ref.name.partition("_")[2]


def words(mate: Mate) -> tuple[list[str], bool]:
    """The words of a joint's name, and whether it is inverted."""
    every = rest(mate).split("_")
    inverted = every[-1] in INVERTED
    return every[:-1] if inverted else every, inverted


def apart(mate: Mate) -> str:
    """The mate with FASTENED as a fixed joint between two links, not as one link."""
    return "FIXED" if mate.ref.type == "FASTENED" else mate.ref.type


def joint(mate: Mate, assembly: Assembly, log: Diagnostics) -> Iterator[Mate]:
    """A `dof_` mate under its own name, reversed where it is inverted."""
    own, inverted = words(mate)
    name = "_".join(own)
    if not legal(name):
        log.report("E-PEER-NAME", "the joint has no name after dof_", mate.title, "call it dof_NAME")
        return
    limits = dict(mate.limits or {})
    first, second = mate.entities
    if mate.ref.type == "CYLINDRICAL":
        # Its frames have no common origin, but those of a REVOLUTE have: the first entity's.
        slide = (inverse(assembly.world_from(second)) @ assembly.world_from(first))[2, 3]
        along = np.eye(4)
        along[2, 3] = slide
        second = replace(second, occurrence_from_frame=frozen(second.occurrence_from_frame @ along))
        limits = {side: end for side, end in limits.items() if "Axial" in side}
        what = "a CYLINDRICAL dof_ mate is a revolute joint, as in onshape-to-robot: it does not slide"
        log.report("W-PEER-SLIDE", what, mate.title, "set conventions: linkwright for both")
    kind = "REVOLUTE" if mate.ref.type == "CYLINDRICAL" else apart(mate)
    if kind == "REVOLUTE" and ENDLESS.intersection(own):
        limits = {}
    if inverted:
        first, second = (
            replace(one, occurrence_from_frame=frozen(one.occurrence_from_frame @ FLIP))
            for one in (first, second)
        )
        limits = {_FLIPPED.get(side, side): -end if side in _FLIPPED else end for side, end in limits.items()}
    ref = replace(mate.ref, name=name, type=kind)
    yield replace(mate, ref=ref, entities=(first, second), limits=limits)


def turned_round(relation: MateRelation, inverted: Collection[tuple[Path, str]]) -> MateRelation:
    """The relation between values that count backwards where their mates are inverted."""
    turned = sum(mate in inverted for mate in relation.mates) % 2 == 1
    return replace(relation, reverse=relation.reverse != turned)
