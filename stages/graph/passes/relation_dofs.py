"""Which dofs a relation joins, and by what factor: as drawn, or as the user says. What it cannot mean is
told by name."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from stages.graph.globs import as_key, entries_of
from stages.graph.keys import RelationKeys
from stages.graph.mechanism import RelationSpec
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
class DofRelation:
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
    """Why a spec joins no dofs."""


def named(robot: Robot, specs: Sequence[RelationSpec]) -> list[RelationSpec]:
    """The specs sorted by title, each with its own name, else a free one made from its title."""
    taken = {joint.name for joint in robot.joints} | {loop.name for loop in robot.loops}
    taken |= {dof.name for dof in robot.dofs} | {spec.name for spec in specs}
    found = []
    for spec in sorted(specs, key=lambda b: (b.title, b.connections, b.type)):
        name = spec.name or free(legal(spec.title.rsplit("/", 1)[-1]) or "relation", taken)
        taken.add(name)
        found.append(replace(spec, name=name))
    return found


def settled(
    specs: Sequence[RelationSpec], wanted: Mapping[str, RelationKeys], log: Diagnostics
) -> list[RelationSpec]:
    """The specs as `relations:` has them: dropped, inverted, with another offset. Later entries win, field
    by field; a glob fits names, titles, and their last pieces. E-GLOB for one that fits nothing."""
    things = [{spec.name, spec.title, spec.title.rsplit("/", 1)[-1]} for spec in specs]
    entries = list(wanted.values())
    found = []
    for spec, fits in zip(specs, entries_of(things, wanted, "relations", "relation", log), strict=True):
        told: dict[str, bool | float] = {}
        for index in fits:
            told |= entries[index].model_dump(exclude_none=True)
        if told.get("drop"):
            continue
        against = bool(told.get("invert"))
        found.append(
            replace(
                spec,
                reverse=spec.reverse != against,
                ratio=-spec.ratio if against and spec.type == "MIMIC" else spec.ratio,
                offset=told.get("offset", spec.offset),
                sure="invert" in told,
            )
        )
    return found


def dof_relations(robot: Robot, specs: Sequence[RelationSpec], log: Diagnostics) -> tuple[DofRelation, ...]:
    """The specs that join two dofs of the tree; the others are told (W-RELATION), and those that
    contradict themselves (E-RELATION)."""
    found = []
    joints = {joint.name: joint for joint in robot.joints}
    scalar = {dof.name for dof in robot.dofs if dof.kind in ("turn", "slide")}
    for spec in specs:
        try:
            one = _said(robot, scalar, spec) if spec.type == "MIMIC" else _joined(robot, joints, spec)
        except _Unfit as why:
            # Only a robot's own file says a relation in full.
            hint = "mend it in the file" if spec.type == "MIMIC" else "mend it, or its mates, in Onshape"
            hint += f", or leave it out: relations: {{{as_key(spec.name)}: {{drop: true}}}}"
            log.report("W-RELATION", f"{why}: its joints move independently", spec.title, hint)
            continue
        if one is None:
            text = f"a SCREW is of one CYLINDRICAL mate: {' and '.join(map(repr, spec.connections))} is none"
            log.report("E-RELATION", text, spec.title, "make the mate CYLINDRICAL")
        elif one.driver == one.follower:
            text = f"the joint {one.driver!r} is related to itself"
            log.report("E-RELATION", text, spec.title, "choose two that are different")
        else:
            found.append(one)
    return tuple(found)


def _joined(robot: Robot, joints: Mapping[str, Joint], spec: RelationSpec) -> DofRelation | None:
    """The dofs and the factor of a spec; None for a screw that is none; _Unfit with the reason."""
    if spec.type not in PAIRS:
        msg = f"a {spec.type} relation is not supported"
        raise _Unfit(msg)
    meant = _joints(robot, joints, spec)
    if spec.type == "SCREW":
        if any(joint.type != "cylindrical" for joint in meant):
            return None
        meant = (*meant, *meant)
    kinds, (driver, follower) = _dofs(spec, *meant)
    factor = _factor(spec, kinds)
    factor = factor if spec.reverse else -factor
    return DofRelation(spec.title, driver, follower, factor, spec.offset, spec.name, sure=spec.sure)


def _said(robot: Robot, scalar: Collection[str], spec: RelationSpec) -> DofRelation:
    """A MIMIC names dofs, turns or slides, and says the rest itself."""
    driver, follower = spec.connections
    for name in spec.connections:
        if name not in scalar:
            raise _Unfit(_why_no_joint(robot, name))
    return DofRelation(spec.title, driver, follower, spec.ratio, spec.offset or 0.0, spec.name, said=True)


def _joints(robot: Robot, joints: Mapping[str, Joint], spec: RelationSpec) -> tuple[Joint, ...]:
    wanted = 1 if spec.type == "SCREW" else 2
    names = spec.connections if wanted == 2 else tuple(dict.fromkeys(spec.connections))
    if len(names) != wanted:
        msg = f"a {spec.type} relation is of {wanted} mate(s), and this one has {len(names)}"
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


def _dofs(spec: RelationSpec, first: Joint, second: Joint) -> tuple[tuple[DofKind, DofKind], tuple[str, str]]:
    """The one pair of dofs that the spec can mean."""
    fits = [
        ((one.kind, other.kind), (one.name, other.name))
        for kinds in PAIRS[spec.type]
        for one in first.dofs
        for other in second.dofs
        if (one.kind, other.kind) == kinds
    ]
    if len(fits) == 1:
        return fits[0]
    types = f"{first.name!r} ({first.type}) and {second.name!r} ({second.type})"
    if fits:
        pairs = ", ".join(" and ".join(names) for _, names in fits)
        msg = f"a {spec.type} relation of {types} may mean more than one pair: {pairs}"
    else:
        wanted = " or ".join(f"a {one} and a {other}" for one, other in PAIRS[spec.type])
        msg = f"a {spec.type} relation needs {wanted}, which {types} do not have"
    raise _Unfit(msg)


def _factor(spec: RelationSpec, kinds: tuple[DofKind, DofKind]) -> float:
    """k > 0 of follower = ±k · driver, by the kinds of driver and follower."""
    by_ratio = kinds[0] == kinds[1]
    size = spec.ratio if by_ratio else spec.length
    if not (size > 0 and math.isfinite(size)):
        msg = f"the relation has the {'ratio' if by_ratio else 'length'} {size:g}"
        raise _Unfit(msg)
    if by_ratio:
        return size
    return size / math.tau if kinds[0] == "turn" else math.tau / size
