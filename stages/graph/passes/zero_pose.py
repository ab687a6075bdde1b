"""The zero of q: the saved pose in place of the pose where the mates' frames coincide."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from stages.graph.passes.relations import negligible
from stages.robot.diagnostics import Diagnostics
from stages.robot.model import Array, Dof, Limits, Relation, Robot, Value, frozen
from stages.robot.poses import at_rest, motion


def with_zero(robot: Robot, zero: Literal["mate", "saved"], log: Diagnostics) -> Robot:
    """The robot with q = 0 where the key `zero` has it."""
    return zeroed(robot, log) if zero == "saved" else robot


def zeroed(robot: Robot, log: Diagnostics) -> Robot:
    """The same robot with q = 0 at the saved pose: limits and offsets of relations are shifted.

    M(s + q) = M(s) M(q) for turns and slides, and for a ball with the product of quaternions: each
    M(s) goes to the transform before its dof, so that every link keeps its frame at every pose. A
    ball with a cone keeps its zero, as the cone is about the mate's own axis (W-ZERO).
    """
    for dof in (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs)):
        if _keeps_its_zero(dof):
            text = "a ball with a cone keeps q = 0 where its mate's frames coincide"
            hint = "the cone is about the mate's own axis: remove the limit to count from the saved pose"
            log.report("W-ZERO", text, dof.name, hint)
    joints, loops = [], []
    for joint in robot.joints:
        start, dofs = _moved_up(joint.parent_from_joint, joint.dofs)
        joints.append(replace(joint, parent_from_joint=start, dofs=dofs))
    for loop in robot.loops:
        start, dofs = _moved_up(loop.b_from_frame, loop.dofs)
        loops.append(replace(loop, b_from_frame=start, dofs=dofs))
    saved = {dof.name: dof.saved for dof in robot.dofs}
    relations = tuple(_shifted(relation, saved) for relation in robot.relations)
    return replace(robot, joints=tuple(joints), loops=tuple(loops), relations=relations)


def _keeps_its_zero(dof: Dof) -> bool:
    return dof.kind == "ball" and dof.limits != Limits() and dof.saved != at_rest("ball")


def _moved_up(start: Array, dofs: Sequence[Dof]) -> tuple[Array, tuple[Dof, ...]]:
    """The transform (4, 4) before a chain, and the chain, counted from the saved pose."""
    made: list[Dof] = []
    for dof in dofs:
        if _keeps_its_zero(dof):
            made.append(dof)
            continue
        origin = frozen(dof.origin @ motion(dof.kind, dof.axis, dof.saved) + 0.0)
        limits = dof.limits
        if isinstance(dof.saved, float):
            lower, upper = (None if end is None else end - dof.saved for end in (limits.lower, limits.upper))
            limits = Limits(lower, upper)
        made.append(replace(dof, origin=origin, limits=limits, saved=at_rest(dof.kind)))
    if not made:
        return start, ()
    start = frozen(start @ made[0].origin + 0.0)
    return start, (replace(made[0], origin=frozen(np.eye(4))), *made[1:])


def _shifted(relation: Relation, saved: Mapping[str, Value]) -> Relation:
    """f + s_f = k (d + s_d) + offset; a rest that is only rounding of the saved pose is dropped."""
    driver, follower = saved[relation.driver], saved[relation.follower]
    if not isinstance(driver, float) or not isinstance(follower, float):
        return relation
    offset = relation.multiplier * driver + relation.offset - follower
    return replace(relation, offset=0.0 if negligible(offset, relation.multiplier) else offset)
