"""Finds the dofs that a relation joins, and its factor: as in CAD, or as the user configures it."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.globs import entries_of
from linkwright.stages.graph.mechanism import RelationSpec
from linkwright.stages.graph.relation_steps import DofRelation
from linkwright.stages.graph.section import RelationSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import DofKind, Joint, Robot
from linkwright.stages.robot.quantity_keys import misfit, unit_hint
from linkwright.stages.robot.text.globs import name_list, yaml_key
from linkwright.stages.robot.text.names import free_name, legal_name

DOF_KIND_PAIRS: Mapping[str, tuple[tuple[DofKind, DofKind], ...]] = {
    "GEAR": (("turn", "turn"),),
    "LINEAR": (("slide", "slide"),),
    "RACK_AND_PINION": (("turn", "slide"), ("slide", "turn")),
    "SCREW": (("turn", "slide"),),
}
"""Type of relation → the kinds of dofs that it may join, driver first."""


class _Unfit(Exception):
    """An error for a relation that joins no dofs; its text is the reason."""


def with_relation_names(robot: Robot, specs: Sequence[RelationSpec]) -> list[RelationSpec]:
    """Returns the relations sorted by title, each with its own name, else a free name made from its title."""
    taken_names = {joint.name for joint in robot.joints} | {loop.name for loop in robot.loops}
    taken_names |= {dof.name for dof in robot.dofs} | {spec.name for spec in specs}
    named_specs = []
    for spec in sorted(specs, key=lambda b: (b.title, b.connections, b.type)):
        name = spec.name or free_name(legal_name(spec.title.rsplit("/", 1)[-1]) or "relation", taken_names)
        taken_names.add(name)
        named_specs.append(replace(spec, name=name))
    return named_specs


def with_configured_relations(
    specs: Sequence[RelationSpec], sections: Mapping[str, RelationSection], log: Diagnostics
) -> list[RelationSpec]:
    """Returns the relations as the key `relations` changes them: without dropped ones, inverted, or with
    another offset. Later entries win, field by field; a glob is compared with names, titles, and the titles'
    last parts. Reports E-GLOB for a glob that matches nothing."""
    name_groups = [{spec.name, spec.title, spec.title.rsplit("/", 1)[-1]} for spec in specs]
    entries = list(sections.values())
    configured_specs = []
    for spec, indices in zip(
        specs, entries_of(name_groups, sections, "relations", "relation", log), strict=True
    ):
        keys: dict[str, bool | float] = {}
        for index in indices:
            keys |= {key: value for key, value in entries[index] if value is not None}
        if keys.get("drop"):
            continue
        is_inverted = bool(keys.get("invert"))
        configured_specs.append(
            replace(
                spec,
                reverse=spec.reverse != is_inverted,
                ratio=-spec.ratio if is_inverted and spec.type == "MIMIC" else spec.ratio,
                offset=keys.get("offset", spec.offset),
                is_direction_chosen="invert" in keys,
            )
        )
    return configured_specs


def dof_relations(robot: Robot, specs: Sequence[RelationSpec], log: Diagnostics) -> tuple[DofRelation, ...]:
    """Returns the relations that join two dofs of the tree. Reports W-RELATION for the others, E-RELATION for
    those that contradict themselves."""
    relations = []
    joints = {joint.name: joint for joint in robot.joints}
    kinds = {dof.name: dof.kind for dof in robot.dofs}
    scalar_dofs = {name for name, kind in kinds.items() if kind in ("turn", "slide")}
    for spec in specs:
        try:
            relation = (
                _mimicked(robot, scalar_dofs, spec) if spec.type == "MIMIC" else _joined(robot, joints, spec)
            )
        except _Unfit as why:
            # Only a robot's own file has a MIMIC.
            hint = (
                "correct it in the file" if spec.type == "MIMIC" else "correct it, or its mates, in Onshape"
            )
            hint += f", or drop it: relations: {{{yaml_key(spec.name)}: {{drop: true}}}}"
            log.report("W-RELATION", f"{why}: its joints move independently", spec.title, hint)
            continue
        if relation is None:
            mates = name_list(map(repr, spec.connections))
            text = f"a SCREW relation needs one CYLINDRICAL mate; {mates} is of another type"
            log.report("E-RELATION", text, spec.title, "make the mate CYLINDRICAL")
        elif text := misfit(spec.offset, kind := kinds[relation.follower]):
            text = f"offset: {text}, and {relation.follower} is a {kind}"
            log.report("E-RELATION", text, spec.title, unit_hint(kind))
        elif relation.driver == relation.follower:
            text = f"the joint {relation.driver!r} is related to itself"
            log.report("E-RELATION", text, spec.title, "choose two different joints")
        else:
            relations.append(relation)
    return tuple(relations)


def _joined(robot: Robot, joints: Mapping[str, Joint], spec: RelationSpec) -> DofRelation | None:
    """Returns the dofs and the factor of a relation; None for a SCREW without its CYLINDRICAL mate; raises
    _Unfit with the reason."""
    if spec.type not in DOF_KIND_PAIRS:
        msg = f"a {spec.type} relation is not supported"
        raise _Unfit(msg)
    joined_joints = _joints(robot, joints, spec)
    if spec.type == "SCREW":
        if any(joint.type != "cylindrical" for joint in joined_joints):
            return None
        joined_joints = (*joined_joints, *joined_joints)
    kinds, (driver, follower) = _dofs(spec, *joined_joints)
    factor = _factor(spec, kinds)
    factor = factor if spec.reverse else -factor
    offset = None if spec.offset is None else float(spec.offset)
    return DofRelation(
        spec.title, driver, follower, factor, offset, spec.name, is_direction_chosen=spec.is_direction_chosen
    )


def _mimicked(robot: Robot, scalar_dofs: Collection[str], spec: RelationSpec) -> DofRelation:
    """Returns the relation of a MIMIC, which names dofs, turns or slides, and has the factor and the offset
    itself."""
    driver, follower = spec.connections
    for name in spec.connections:
        if name not in scalar_dofs:
            raise _Unfit(_why_no_joint(robot, name))
    offset = float(spec.offset or 0.0)
    return DofRelation(spec.title, driver, follower, spec.ratio, offset, spec.name, complete=True)


def _joints(robot: Robot, joints: Mapping[str, Joint], spec: RelationSpec) -> tuple[Joint, ...]:
    expected = 1 if spec.type == "SCREW" else 2
    names = spec.connections if expected == 2 else tuple(dict.fromkeys(spec.connections))
    if len(names) != expected:
        mates = "1 mate" if expected == 1 else f"{expected} mates"
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
    """Returns the kinds and the names of the only pair of dofs that the relation can join; raises _Unfit if
    no pair or several pairs fit."""
    pairs_of_dofs = [
        ((driver.kind, follower.kind), (driver.name, follower.name))
        for kinds in DOF_KIND_PAIRS[spec.type]
        for driver in first.dofs
        for follower in second.dofs
        if (driver.kind, follower.kind) == kinds
    ]
    if len(pairs_of_dofs) == 1:
        return pairs_of_dofs[0]
    types = f"{first.name!r} ({first.type}) and {second.name!r} ({second.type})"
    if pairs_of_dofs:
        pairs = ", ".join(" and ".join(names) for _, names in pairs_of_dofs)
        msg = f"a {spec.type} relation of {types} is ambiguous: it may join {pairs}"
    else:
        expected = " or ".join(
            f"a {driver} and a {follower}" for driver, follower in DOF_KIND_PAIRS[spec.type]
        )
        msg = f"a {spec.type} relation needs {expected}, which {types} do not have"
    raise _Unfit(msg)


def _factor(spec: RelationSpec, kinds: tuple[DofKind, DofKind]) -> float:
    """Returns k > 0 of follower = ±k · driver, by the kinds of driver and follower."""
    by_ratio = kinds[0] == kinds[1]
    size = spec.ratio if by_ratio else spec.length
    if not (size > 0 and math.isfinite(size)):
        msg = f"the relation has an invalid {'ratio' if by_ratio else 'length'} {size:g}"
        raise _Unfit(msg)
    if by_ratio:
        return size
    return size / math.tau if kinds[0] == "turn" else math.tau / size
