"""Sets the zero and the direction of each joint value q relative to the value of its mate.
q = 0 is the pose in which the mates' frames coincide, or with `zero: saved` the saved pose; `joints` may give
a dof a zero of its own, and invert it: value of the mate = zero + sign · q.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from linkwright.stages.graph.passes.relations import is_negligible
from linkwright.stages.graph.section import JointSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.dofs import AS_THE_MATE
from linkwright.stages.robot.model.poses import at_rest, motion
from linkwright.stages.robot.model.robot import Array, Dof, Limits, MateValue, Relation, Robot, frozen
from linkwright.stages.robot.text.globs import matches_glob

SCALAR_KINDS = ("turn", "slide")


def with_zero(
    robot: Robot, zero: Literal["mate", "saved"], joints: Mapping[str, JointSection], log: Diagnostics
) -> Robot:
    """Returns the robot with the zeros and directions of its joint values that the keys `zero`,
    `joints.*.zero` and `joints.*.invert` choose; later entries win.

    Reports E-JOINT for an entry that names no turn or slide, and W-ZERO for a ball with a cone: it keeps
    its zero, as the cone is about the mate's own axis.
    """
    dofs = (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs))
    _check(dofs, joints, log)
    mate_values = {dof.name: _mate_value(dof, zero, joints, log) for dof in dofs}
    measured_dofs = {
        name for name, count in mate_values.items() if zero == "saved" and not _has_own_zero(name, joints)
    }
    return with_counted_dofs(robot, mate_values, measured_dofs)


def with_counted_dofs(robot: Robot, counts: Mapping[str, MateValue], measured_dofs: Collection[str]) -> Robot:
    """Returns the same robot with other zeros and signs of q: limits, saved values and relations are
    converted.

    With M the motion about an axis a, M(a, z + s q) = M(a, z) M(s a, q) for turns and slides, and for a ball
    with the product of quaternions: each M(a, z) goes to the transform before its dof, so that every link
    keeps its frame at every pose. `measured_dofs`: the dofs whose zero is the saved value, where an offset of
    a relation may be rounding.
    """
    if all(count == AS_THE_MATE for count in counts.values()):
        return robot
    joints, loops = [], []
    for joint in robot.joints:
        start, dofs = _converted_chain(joint.parent_from_joint, joint.dofs, counts)
        joints.append(replace(joint, parent_from_joint=start, dofs=dofs))
    for loop in robot.loops:
        start, dofs = _converted_chain(loop.b_from_frame, loop.dofs, counts)
        loops.append(replace(loop, b_from_frame=start, dofs=dofs))
    relations = tuple(_converted_relation(relation, counts, measured_dofs) for relation in robot.relations)
    return replace(robot, joints=tuple(joints), loops=tuple(loops), relations=relations)


def _check(dofs: Sequence[Dof], joints: Mapping[str, JointSection], log: Diagnostics) -> None:
    for glob, keys in joints.items():
        matching_dofs = [dof for dof in dofs if matches_glob(dof.name, glob)]
        kinds = {dof.kind for dof in matching_dofs}
        set_keys = [key for key in ("zero", "invert") if getattr(keys, key) is not None]
        if set_keys and matching_dofs and not kinds & set(SCALAR_KINDS):
            text = f"{glob!r} matches only balls or free joints, which have no {' and no '.join(set_keys)}"
            log.report("E-JOINT", text, "joints", f"leave {' and '.join(set_keys)} out")
        elif keys.zero and kinds >= set(SCALAR_KINDS):
            description = ", ".join(
                f"{dof.name} ({dof.kind})" for dof in matching_dofs if dof.kind in SCALAR_KINDS
            )
            text = f"{glob!r} gives one zero to dofs of several kinds: {description}"
            log.report("E-JOINT", text, "joints", "give a zero to each kind under its own glob")


def _has_own_zero(name: str, joints: Mapping[str, JointSection]) -> bool:
    return any(keys.zero is not None and matches_glob(name, glob) for glob, keys in joints.items())


def _mate_value(
    dof: Dof, zero: Literal["mate", "saved"], joints: Mapping[str, JointSection], log: Diagnostics
) -> MateValue:
    if dof.kind not in SCALAR_KINDS:
        if zero == "mate":
            return AS_THE_MATE
        if dof.kind == "ball" and dof.limits != Limits() and dof.saved != at_rest("ball"):
            text = "a ball with a cone keeps q = 0 where its mate's frames coincide"
            hint = "the cone is about the mate's own axis: remove the limit to count from the saved pose"
            log.report("W-ZERO", text, dof.name, hint)
            return AS_THE_MATE
        return MateValue(1, dof.saved)
    mate_value = MateValue(1, dof.saved) if zero == "saved" else AS_THE_MATE
    for glob, keys in joints.items():
        if matches_glob(dof.name, glob):
            mate_value = mate_value if keys.zero is None else replace(mate_value, zero=float(keys.zero))
            mate_value = (
                mate_value if keys.invert is None else replace(mate_value, sign=-1 if keys.invert else 1)
            )
    return mate_value


def _converted_chain(
    start: Array, dofs: Sequence[Dof], counts: Mapping[str, MateValue]
) -> tuple[Array, tuple[Dof, ...]]:
    """Returns the transform (4, 4) before a chain, and the chain, with the new zeros and signs."""
    counted_dofs = [_converted_dof(dof, counts[dof.name]) for dof in dofs]
    if not counted_dofs:
        return start, ()
    if not np.array_equal(counted_dofs[0].origin, np.eye(4)):
        start = frozen(start @ counted_dofs[0].origin + 0.0)
    return start, (replace(counted_dofs[0], origin=frozen(np.eye(4))), *counted_dofs[1:])


def _converted_dof(dof: Dof, count: MateValue) -> Dof:
    if count == AS_THE_MATE:
        return dof
    at_zero = motion(dof.kind, dof.axis, count.zero)
    converted = replace(dof, origin=frozen(dof.origin @ at_zero + 0.0), mate_value=count)
    if not isinstance(dof.saved, float):
        return replace(converted, saved=at_rest(dof.kind))
    limits = dof.limits.mapped(count.sign, count.from_mate(0.0))
    axis = frozen(count.sign * dof.axis + 0.0)
    spring = dof.spring and replace(dof.spring, reference=count.from_mate(dof.spring.reference))
    return replace(converted, axis=axis, limits=limits, saved=count.from_mate(dof.saved), spring=spring)


def _converted_relation(
    relation: Relation, counts: Mapping[str, MateValue], measured_dofs: Collection[str]
) -> Relation:
    """Returns the relation in the new values: z_f + s_f f = k (z_d + s_d d) + offset, solved for f. An offset
    that is only rounding of the saved pose is dropped."""
    driver, follower = counts[relation.driver], counts[relation.follower]
    factor = follower.sign * driver.sign * relation.multiplier + 0.0
    offset = follower.from_mate(relation.multiplier * driver.to_mate(0.0) + relation.offset)
    if (
        relation.driver in measured_dofs
        and relation.follower in measured_dofs
        and is_negligible(offset, factor)
    ):
        offset = 0.0
    return replace(relation, multiplier=factor, offset=offset)
