"""Which dofs a relation joins, and by what factor: as drawn, or as the user says. What it cannot mean is
told by name."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from stages.graph.globs import as_key, entries_of
from stages.graph.keys import RelationKeys
from stages.graph.mechanism import Bond
from stages.robot.diagnostics import Diagnostics
from stages.robot.model import DofKind, Joint, Robot
from stages.robot.names import free, legal

PAIRS: Mapping[str, tuple[tuple[DofKind, DofKind], ...]] = {
    "GEAR": (("turn", "turn"),),
    "LINEAR": (("slide", "slide"),),
    "RACK_AND_PINION": (("turn", "slide"), ("slide", "turn")),
    "SCREW": (("turn", "slide"),),
}
"""Type of relation → the kinds of dofs that it may join, driver first."""


@dataclass(frozen=True, slots=True)
class Bonded:
    """`follower` = factor · `driver` + offset, names of dofs; the offset is None where the saved pose tells
    it. `said`: the source says it all, and has no pose of its own. `sure`: the user chose the direction."""

    title: str
    driver: str
    follower: str
    factor: float
    offset: float | None = None
    name: str = ""
    said: bool = False
    sure: bool = False


class _Unfit(Exception):
    """Why a bond joins no dofs."""


def named(robot: Robot, bonds: Sequence[Bond]) -> list[Bond]:
    """The bonds sorted by title, each with its own name, else a free one made from its title."""
    taken = {joint.name for joint in robot.joints} | {loop.name for loop in robot.loops}
    taken |= {dof.name for dof in robot.dofs} | {bond.name for bond in bonds}
    found = []
    for bond in sorted(bonds, key=lambda b: (b.title, b.couplings, b.type)):
        name = bond.name or free(legal(bond.title.rsplit("/", 1)[-1]) or "relation", taken)
        taken.add(name)
        found.append(replace(bond, name=name))
    return found


def settled(bonds: Sequence[Bond], wanted: Mapping[str, RelationKeys], log: Diagnostics) -> list[Bond]:
    """The bonds as `relations:` has them: dropped, inverted, with another offset. Later entries win, field
    by field; a glob fits names, titles, and their last pieces. E-GLOB for one that fits nothing."""
    things = [{bond.name, bond.title, bond.title.rsplit("/", 1)[-1]} for bond in bonds]
    entries = list(wanted.values())
    found = []
    for bond, fits in zip(bonds, entries_of(things, wanted, "relations", "relation", log), strict=True):
        told: dict[str, bool | float] = {}
        for index in fits:
            told |= entries[index].model_dump(exclude_none=True)
        if told.get("drop"):
            continue
        against = bool(told.get("invert"))
        found.append(
            replace(
                bond,
                reverse=bond.reverse != against,
                ratio=-bond.ratio if against and bond.type == "MIMIC" else bond.ratio,
                offset=told.get("offset", bond.offset),
                sure="invert" in told,
            )
        )
    return found


def bonded(robot: Robot, bonds: Sequence[Bond], log: Diagnostics) -> tuple[Bonded, ...]:
    """The bonds that join two dofs of the tree; the others are told (W-RELATION), and those that
    contradict themselves (E-RELATION)."""
    found = []
    joints = {joint.name: joint for joint in robot.joints}
    scalar = {dof.name for dof in robot.dofs if dof.kind in ("turn", "slide")}
    for bond in bonds:
        try:
            one = _said(robot, scalar, bond) if bond.type == "MIMIC" else _bonded(robot, joints, bond)
        except _Unfit as why:
            # Only a robot's own file says a relation in full.
            hint = "mend it in the file" if bond.type == "MIMIC" else "mend it, or its mates, in Onshape"
            hint += f", or leave it out: relations: {{{as_key(bond.name)}: {{drop: true}}}}"
            log.report("W-RELATION", f"{why}: its joints move independently", bond.title, hint)
            continue
        if one is None:
            text = f"a SCREW is of one CYLINDRICAL mate: {' and '.join(map(repr, bond.couplings))} is none"
            log.report("E-RELATION", text, bond.title, "make the mate CYLINDRICAL")
        elif one.driver == one.follower:
            text = f"the joint {one.driver!r} is related to itself"
            log.report("E-RELATION", text, bond.title, "choose two that are different")
        else:
            found.append(one)
    return tuple(found)


def _bonded(robot: Robot, joints: Mapping[str, Joint], bond: Bond) -> Bonded | None:
    """The dofs and the factor of a bond; None for a screw that is none; _Unfit with the reason."""
    if bond.type not in PAIRS:
        msg = f"a {bond.type} relation is not supported"
        raise _Unfit(msg)
    meant = _joints(robot, joints, bond)
    if bond.type == "SCREW":
        if any(joint.type != "cylindrical" for joint in meant):
            return None
        meant = (*meant, *meant)
    kinds, (driver, follower) = _dofs(bond, *meant)
    factor = _factor(bond, kinds)
    factor = factor if bond.reverse else -factor
    return Bonded(bond.title, driver, follower, factor, bond.offset, bond.name, sure=bond.sure)


def _said(robot: Robot, scalar: Collection[str], bond: Bond) -> Bonded:
    """A MIMIC names dofs, turns or slides, and says the rest itself."""
    driver, follower = bond.couplings
    for name in bond.couplings:
        if name not in scalar:
            raise _Unfit(_why_no_joint(robot, name))
    return Bonded(bond.title, driver, follower, bond.ratio, bond.offset or 0.0, bond.name, said=True)


def _joints(robot: Robot, joints: Mapping[str, Joint], bond: Bond) -> tuple[Joint, ...]:
    wanted = 1 if bond.type == "SCREW" else 2
    names = bond.couplings if wanted == 2 else tuple(dict.fromkeys(bond.couplings))
    if len(names) != wanted:
        msg = f"a {bond.type} relation is of {wanted} mate(s), and this one has {len(names)}"
        raise _Unfit(msg)
    for name in names:
        if name not in joints:
            raise _Unfit(_why_no_joint(robot, name))
    return tuple(joints[name] for name in names)


def _why_no_joint(robot: Robot, name: str) -> str:
    if any(loop.name == name for loop in robot.loops):
        return f"the relation names {name!r}, which closes a loop (loops.cut chooses another)"
    if name:
        return f"the relation names {name!r}, which is no joint of the robot"
    return "the relation names a mate that moves nothing (broken, suppressed, or inside one link)"


def _dofs(bond: Bond, first: Joint, second: Joint) -> tuple[tuple[DofKind, DofKind], tuple[str, str]]:
    """The one pair of dofs that the bond can mean."""
    fits = [
        ((one.kind, other.kind), (one.name, other.name))
        for kinds in PAIRS[bond.type]
        for one in first.dofs
        for other in second.dofs
        if (one.kind, other.kind) == kinds
    ]
    if len(fits) == 1:
        return fits[0]
    types = f"{first.name!r} ({first.type}) and {second.name!r} ({second.type})"
    if fits:
        pairs = ", ".join(" and ".join(names) for _, names in fits)
        msg = f"a {bond.type} relation of {types} may mean more than one pair: {pairs}"
    else:
        wanted = " or ".join(f"a {one} and a {other}" for one, other in PAIRS[bond.type])
        msg = f"a {bond.type} relation needs {wanted}, which {types} do not have"
    raise _Unfit(msg)


def _factor(bond: Bond, kinds: tuple[DofKind, DofKind]) -> float:
    """k > 0 of follower = ±k · driver, by the kinds of driver and follower."""
    by_ratio = kinds[0] == kinds[1]
    size = bond.ratio if by_ratio else bond.length
    if not (size > 0 and math.isfinite(size)):
        msg = f"the relation has the {'ratio' if by_ratio else 'length'} {size:g}"
        raise _Unfit(msg)
    if by_ratio:
        return size
    return size / math.tau if kinds[0] == "turn" else math.tau / size
