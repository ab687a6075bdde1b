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
"""Half a turn about x: a mate with both frames so turned measures all its motions in reverse, except the
slide along x."""

_FLIPPED = {
    f"limit{side}{end}": f"limit{side}{other}"
    for side in ("AxialZ", "Y", "Z")
    for end, other in (("Min", "Max"), ("Max", "Min"))
}


def unprefixed_name(mate: Mate) -> str:
    """Returns a mate's name without its prefix."""
    return mate.ref.name.partition("_")[2]


def words(mate: Mate) -> tuple[list[str], bool]:
    """Returns the words of a joint's name, and whether it is inverted."""
    all_words = unprefixed_name(mate).split("_")
    inverted = all_words[-1] in INVERTED
    return all_words[:-1] if inverted else all_words, inverted


def type_between_links(mate: Mate) -> str:
    """Returns the type of a mate between two links: a FASTENED mate is a fixed joint, not one link."""
    return "FIXED" if mate.ref.type == "FASTENED" else mate.ref.type


def dof_mate(mate: Mate, assembly: Assembly, log: Diagnostics) -> Iterator[Mate]:
    """Yields a `dof_` mate under its own name, reversed where it is inverted."""
    name_words, inverted = words(mate)
    name = "_".join(name_words)
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
        message = "a CYLINDRICAL dof_ mate is a revolute joint, as in onshape-to-robot: it does not slide"
        log.report("W-PEER-SLIDE", message, mate.title, "set conventions: linkwright for both")
    kind = "REVOLUTE" if mate.ref.type == "CYLINDRICAL" else type_between_links(mate)
    if kind == "REVOLUTE" and ENDLESS.intersection(name_words):
        limits = {}
    if inverted:
        first, second = (
            replace(entity, occurrence_from_frame=frozen(entity.occurrence_from_frame @ FLIP))
            for entity in (first, second)
        )
        limits = {_FLIPPED.get(side, side): -end if side in _FLIPPED else end for side, end in limits.items()}
    ref = replace(mate.ref, name=name, type=kind)
    yield replace(mate, ref=ref, entities=(first, second), limits=limits)


def turned_round(relation: MateRelation, inverted: Collection[tuple[Path, str]]) -> MateRelation:
    """Returns the relation between values that count backwards where their mates are inverted."""
    turned = sum(mate in inverted for mate in relation.mates) % 2 == 1
    return replace(relation, reverse=relation.reverse != turned)
