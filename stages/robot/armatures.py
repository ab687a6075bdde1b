"""The robot as it is built: with the armatures that were added."""

from collections.abc import Mapping
from dataclasses import replace

from stages.robot.actuation import Actuation
from stages.robot.model import Dof, Robot


def with_armatures(robot: Robot, actuation: Actuation) -> Robot:
    """The robot whose dofs have the armatures of `actuation`."""
    added = {one.dof: one.value for one in actuation.armatures}
    if not added:
        return robot
    joints = tuple(
        replace(joint, dofs=tuple(_with(dof, added) for dof in joint.dofs)) for joint in robot.joints
    )
    loops = tuple(replace(loop, dofs=tuple(_with(dof, added) for dof in loop.dofs)) for loop in robot.loops)
    return replace(robot, joints=joints, loops=loops)


def _with(dof: Dof, added: Mapping[str, float]) -> Dof:
    if dof.name not in added:
        return dof
    return replace(dof, dynamics=replace(dof.dynamics, armature=added[dof.name]))
