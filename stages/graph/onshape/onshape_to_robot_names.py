"""Reads mates' names as onshape-to-robot does: joints with their directions and limits, loops and welds."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from linkwright.stages.graph.onshape.assembly import Assembly, Mate, MateRelation, Path
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import frozen
from linkwright.stages.robot.text.names import legal_name

DOF, CLOSING, FRAME, FIX = "dof_", "closing_", "frame_", "fix_"
"""Prefixes of names: joints, closed loops, frames, and welds."""

IGNORED_MATES: Mapping[str, tuple[str, str]] = {
    "origin": (
        "mates to the assembly's origin are ignored, as by onshape-to-robot",
        "fix the part instead, or set root.base: fixed",
    ),
    "without prefix": (
        "mates without a prefix are ignored, as by onshape-to-robot",
        "call it dof_NAME for a joint, or fix_NAME for a weld",
    ),
    "inner": (
        "mates inside a sub-assembly are ignored, as by onshape-to-robot: it is rigid",
        "name it in depth.flexible, or set conventions: linkwright",
    ),
}
"""Reason why mates are ignored → message and hint of its W-PEER-MATE, in the order of the reports."""

INVERTING_WORDS = frozenset({"inv", "inverted"})
"""Words at the end of a joint's name that invert its direction."""

CONTINUOUS_WORDS = frozenset({"wheel", "continuous"})
"""Words in a joint's name that let it turn without limits."""

HALF_TURN_ABOUT_X = frozen(np.diag([1.0, -1.0, -1.0, 1.0]))
"""Half a turn about x. If both frames of a mate are turned by it, all motions of the mate change sign, except
those along and about x."""

_FLIPPED_LIMITS = {
    f"limit{axis}{end}": f"limit{axis}{opposite}"
    for axis in ("AxialZ", "Y", "Z")
    for end, opposite in (("Min", "Max"), ("Max", "Min"))
}
"""Limit of a mate → the limit that takes its place, negated, if both frames are flipped."""


class JointWords(NamedTuple):
    """The words of the name of a joint."""

    words: list[str]
    """The parts of the name between its underscores, without the word for an inverted direction."""

    inverted: bool
    """Whether the direction of the joint is inverted."""


def unprefixed_name(mate: Mate) -> str:
    """Returns a mate's name without its prefix."""
    return mate.ref.name.partition("_")[2]


def joint_words(mate: Mate) -> JointWords:
    """Splits the name of a mate's joint into words."""
    words = unprefixed_name(mate).split("_")
    inverted = words[-1] in INVERTING_WORDS
    return JointWords(words[:-1] if inverted else words, inverted)


def translated_mates(
    assembly: Assembly, mates_by_meaning: Mapping[str, Sequence[Mate]], log: Diagnostics
) -> list[Mate]:
    """Returns the mates of joints, of loops and of welds, and those inside sub-assemblies."""
    joints = [as_joint_mate(mate, assembly, log) for mate in mates_by_meaning[DOF]]
    loop_mates = [
        replace(mate, ref=replace(mate.ref, type=type_between_links(mate)))
        for mate in mates_by_meaning[CLOSING]
        if all(entity.path in assembly.occurrences for entity in mate.entities)
    ]
    welds = [replace(mate, ref=replace(mate.ref, type="FASTENED")) for mate in mates_by_meaning[FIX]]
    inner_mates = [mate for mate in assembly.mates if mate.ref.owner]
    return [*(mate for mate in joints if mate is not None), *loop_mates, *welds, *inner_mates]


def type_between_links(mate: Mate) -> str:
    """Returns the type of the joint that a mate between two links makes. FASTENED becomes FIXED, since this
    mate joins the links but does not merge them."""
    return "FIXED" if mate.ref.type == "FASTENED" else mate.ref.type


def as_joint_mate(mate: Mate, assembly: Assembly, log: Diagnostics) -> Mate | None:
    """Returns a `dof_` mate with the name of its joint, flipped if the name inverts its direction. A
    CYLINDRICAL mate becomes REVOLUTE (W-PEER-SLIDE). Returns None if the joint has no name (E-PEER-NAME)."""
    words, inverted = joint_words(mate)
    name = "_".join(words)
    if not legal_name(name):
        log.report("E-PEER-NAME", "the joint has no name after dof_", mate.title, "call it dof_NAME")
        return None
    if mate.ref.type == "CYLINDRICAL":
        mate = _as_revolute(mate, assembly)
        message = "a CYLINDRICAL dof_ mate is a revolute joint, as in onshape-to-robot: it does not slide"
        log.report("W-PEER-SLIDE", message, mate.title, "to keep the slide, set conventions: linkwright")
    kind = type_between_links(mate)
    limits = dict(mate.limits or {})
    if kind == "REVOLUTE" and CONTINUOUS_WORDS.intersection(words):
        limits = {}
    mate = replace(mate, ref=replace(mate.ref, name=name, type=kind), limits=limits)
    return _flipped(mate) if inverted else mate


def _as_revolute(mate: Mate, assembly: Assembly) -> Mate:
    """Returns a CYLINDRICAL mate as a REVOLUTE."""
    # The frames of a CYLINDRICAL mate may be apart along z, those of a REVOLUTE may not: the second frame is
    # moved to the first.
    first, second = mate.entities
    shift = np.eye(4)
    shift[2, 3] = (inverse(assembly.world_from(second)) @ assembly.world_from(first))[2, 3]
    second = replace(second, occurrence_from_frame=frozen(second.occurrence_from_frame @ shift))
    # Only the limits of the turn apply; limitZMin and limitZMax limit the slide.
    limits = {limit: value for limit, value in (mate.limits or {}).items() if "Axial" in limit}
    return replace(mate, ref=replace(mate.ref, type="REVOLUTE"), entities=(first, second), limits=limits)


def _flipped(mate: Mate) -> Mate:
    """Returns the mate with both frames flipped (see `HALF_TURN_ABOUT_X`)."""
    first, second = (
        replace(entity, occurrence_from_frame=frozen(entity.occurrence_from_frame @ HALF_TURN_ABOUT_X))
        for entity in mate.entities
    )
    limits = {
        _FLIPPED_LIMITS.get(limit, limit): -value if limit in _FLIPPED_LIMITS else value
        for limit, value in (mate.limits or {}).items()
    }
    return replace(mate, entities=(first, second), limits=limits)


def with_inverted_mates(relation: MateRelation, inverted: Collection[tuple[Path, str]]) -> MateRelation:
    """Returns the relation, reversed if an odd number of its mates is inverted: the values of inverted mates
    have the opposite sign. `inverted`: (assembly, feature) of each inverted mate."""
    # Two inverted mates cancel.
    changes_sign = sum(mate in inverted for mate in relation.mates) % 2 == 1
    return replace(relation, reverse=relation.reverse != changes_sign)
