"""Gives a robot's dofs the dynamics of its motors, and added armatures."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from linkwright.stages.robot.model.actuation import Actuation, Supplied
from linkwright.stages.robot.model.robot import Dof, Robot


def with_actuation(robot: Robot, actuation: Actuation) -> Robot:
    """Returns the robot whose dofs have the dynamics that `actuation` gives them."""
    added = [(supplied.dof, supplied.quantity, supplied.value) for supplied in actuation.supplied]
    return _with_dynamics(
        robot, [*added, *((armature.dof, "armature", armature.value) for armature in actuation.armatures)]
    )


def with_motors(robot: Robot, supplied: Iterable[Supplied]) -> Robot:
    """Returns the robot whose dofs have the dynamics that motors give them."""
    return _with_dynamics(
        robot,
        [(entry.dof, entry.quantity, entry.value) for entry in supplied],
    )


def _with_dynamics(robot: Robot, added: Iterable[tuple[str, str, float]]) -> Robot:
    """Returns the robot with `added` dynamics: (dof, quantity, value)."""
    values: dict[str, dict[str, float]] = {}
    for name, quantity, value in added:
        values.setdefault(name, {})[quantity] = value
    if not values:
        return robot
    joints = tuple(
        replace(joint, dofs=tuple(_dof(dof, values) for dof in joint.dofs)) for joint in robot.joints
    )
    loops = tuple(replace(loop, dofs=tuple(_dof(dof, values) for dof in loop.dofs)) for loop in robot.loops)
    return replace(robot, joints=joints, loops=loops)


def _dof(dof: Dof, values: Mapping[str, Mapping[str, float]]) -> Dof:
    if dof.name not in values:
        return dof
    return replace(dof, dynamics=replace(dof.dynamics, **values[dof.name]))
