"""Finds the dofs that a relation joins, and its factor: as drawn, or as the user configures it."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.globs import entries_of
from linkwright.stages.graph.mechanism import RelationSpec
from linkwright.stages.graph.relation_steps import DofRelation
from linkwright.stages.graph.section import RelationSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import DofKind, Joint, Robot
from linkwright.stages.robot.quantity_keys import as_typed, misfit
from linkwright.stages.robot.text.globs import as_key, listed
from linkwright.stages.robot.text.names import free, legal

PAIRS: Mapping[str, tuple[tuple[DofKind, DofKind], ...]] = {
    "GEAR": (("turn", "turn"),),
    "LINEAR": (("slide", "slide"),),
    "RACK_AND_PINION": (("turn", "slide"), ("slide", "turn")),
    "SCREW": (("turn", "slide"),),
}
"""Type of relation → the kinds of dofs that it may join, driver first."""


class _Unfit(Exception):
    """A relation joins no dofs; the text gives the reason."""


def named(robot: Robot, specs: Sequence[RelationSpec]) -> list[RelationSpec]:
    """The relations sorted by title, each with its own name, else a free one made from its title."""
    taken = {joint.name for joint in robot.joints} | {loop.name for loop in robot.loops}
    taken |= {dof.name for dof in robot.dofs} | {spec.name for spec in specs}
    found = []
    for spec in sorted(specs, key=lambda b: (b.title, b.connections, b.type)):
        name = spec.name or free(legal(spec.title.rsplit("/", 1)[-1]) or "relation", taken)
        taken.add(name)
        found.append(replace(spec, name=name))
    return found


def configured(
    specs: Sequence[RelationSpec], wanted: Mapping[str, RelationSection], log: Diagnostics
) -> list[RelationSpec]:
    """The relations after the key `relations`: dropped, inverted, with another offset. Later entries win,
    field by field; a glob fits names, titles, and their last words. E-GLOB for one that fits nothing."""
    things = [{spec.name, spec.title, spec.title.rsplit("/", 1)[-1]} for spec in specs]
    entries = list(wanted.values())
    found = []
    for spec, fits in zip(specs, entries_of(things, wanted, "relations", "relation", log), strict=True):
        given: dict[str, bool | float] = {}
        for index in fits:
            given |= {key: value for key, value in entries[index] if value is not None}
        if given.get("drop"):
            continue
        against = bool(given.get("invert"))
        found.append(
            replace(
                spec,
                reverse=spec.reverse != against,
                ratio=-spec.ratio if against and spec.type == "MIMIC" else spec.ratio,
                offset=given.get("offset", spec.offset),
                sure="invert" in given,
            )
        )
    return found


def dof_relations(robot: Robot, specs: Sequence[RelationSpec], log: Diagnostics) -> tuple[DofRelation, ...]:
    """The relations that join two dofs of the tree. W-RELATION for the others, E-RELATION for those that
    contradict themselves."""
    found = []
    joints = {joint.name: joint for joint in robot.joints}
    kinds = {dof.name: dof.kind for dof in robot.dofs}
    scalar = {name for name, kind in kinds.items() if kind in ("turn", "slide")}
    for spec in specs:
        try:
            one = _mimicked(robot, scalar, spec) if spec.type == "MIMIC" else _joined(robot, joints, spec)
        except _Unfit as why:
            # Only a robot's own file has a MIMIC.
            hint = (
                "correct it in the file" if spec.type == "MIMIC" else "correct it, or its mates, in Onshape"
            )
            hint += f", or drop it: relations: {{{as_key(spec.name)}: {{drop: true}}}}"
            log.report("W-RELATION", f"{why}: its joints move independently", spec.title, hint)
            continue
        if one is None:
            mates = listed(map(repr, spec.connections))
            text = f"a SCREW relation needs one CYLINDRICAL mate; {mates} is not one"
            log.report("E-RELATION", text, spec.title, "make the mate CYLINDRICAL")
        elif text := misfit(spec.offset, kind := kinds[one.follower]):
            text = f"offset: {text}, and {one.follower} is a {kind}"
            log.report("E-RELATION", text, spec.title, as_typed(kind))
        elif one.driver == one.follower:
            text = f"the joint {one.driver!r} is related to itself"
            log.report("E-RELATION", text, spec.title, "choose two different joints")
        else:
            found.append(one)
    return tuple(found)


def _joined(robot: Robot, joints: Mapping[str, Joint], spec: RelationSpec) -> DofRelation | None:
    """The dofs and the factor of a relation; None for a SCREW without its CYLINDRICAL mate; _Unfit with the
    reason."""
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
    offset = None if spec.offset is None else float(spec.offset)
    return DofRelation(spec.title, driver, follower, factor, offset, spec.name, sure=spec.sure)


def _mimicked(robot: Robot, scalar: Collection[str], spec: RelationSpec) -> DofRelation:
    """A MIMIC names dofs, turns or slides, and has the factor and the offset itself."""
    driver, follower = spec.connections
    for name in spec.connections:
        if name not in scalar:
            raise _Unfit(_why_no_joint(robot, name))
    offset = float(spec.offset or 0.0)
    return DofRelation(spec.title, driver, follower, spec.ratio, offset, spec.name, complete=True)


def _joints(robot: Robot, joints: Mapping[str, Joint], spec: RelationSpec) -> tuple[Joint, ...]:
    wanted = 1 if spec.type == "SCREW" else 2
    names = spec.connections if wanted == 2 else tuple(dict.fromkeys(spec.connections))
    if len(names) != wanted:
        mates = "1 mate" if wanted == 1 else f"{wanted} mates"
        msg = f"a {spec.type} relation needs {mates}, and this one has {len(names)}"
        raise _Unfit(msg)
    for name in names:
        if name not in joints:
            raise _Unfit(_why_no_joint(robot, name))
    return tuple(joints[name] for name in names)


def _why_no_joint(robot: Robot, name: str) -> str:
    if any(loop.name == name for loop in robot.loops):
        return f"the relation names {name!r}, which closes a loop (loops.cut chooses another)"
    if name:
        return f"the relation names {name!r}, which is not a joint of the robot"
    return "the relation names a mate that moves nothing (broken, suppressed, or inside one link)"


def _dofs(spec: RelationSpec, first: Joint, second: Joint) -> tuple[tuple[DofKind, DofKind], tuple[str, str]]:
    """The only pair of dofs that the relation can mean."""
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
        msg = f"a {spec.type} relation of {types} is ambiguous: it may join {pairs}"
    else:
        wanted = " or ".join(f"a {one} and a {other}" for one, other in PAIRS[spec.type])
        msg = f"a {spec.type} relation needs {wanted}, which {types} do not have"
    raise _Unfit(msg)


def _factor(spec: RelationSpec, kinds: tuple[DofKind, DofKind]) -> float:
    """k > 0 of follower = ±k · driver, by the kinds of driver and follower."""
    by_ratio = kinds[0] == kinds[1]
    size = spec.ratio if by_ratio else spec.length
    if not (size > 0 and math.isfinite(size)):
        msg = f"the relation has an invalid {'ratio' if by_ratio else 'length'} {size:g}"
        raise _Unfit(msg)
    if by_ratio:
        return size
    return size / math.tau if kinds[0] == "turn" else math.tau / size
