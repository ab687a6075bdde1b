"""Gives a robot's dofs the dynamics that its actuators add: values of motors, and armatures."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from linkwright.stages.robot.model.actuation import Actuation, Supplied
from linkwright.stages.robot.model.robot import Dof, Robot


def with_actuation(robot: Robot, actuation: Actuation) -> Robot:
    """Returns the robot whose dofs have the dynamics of motors and the armatures of `actuation`."""
    armatures = [(armature.dof, "armature", armature.value) for armature in actuation.armatures]
    return _with_values(with_motors(robot, actuation.supplied), armatures)


def with_motors(robot: Robot, supplied: Iterable[Supplied]) -> Robot:
    """Returns the robot whose dofs have the dynamics that motors of the library give them."""
    return _with_values(robot, [(entry.dof, entry.quantity, entry.value) for entry in supplied])


def _with_values(robot: Robot, entries: Iterable[tuple[str, str, float]]) -> Robot:
    """Returns the robot with these entries (dof, quantity of its dynamics, value)."""
    values: dict[str, dict[str, float]] = {}
    for name, quantity, value in entries:
        values.setdefault(name, {})[quantity] = value
    if not values:
        return robot
    joints = tuple(replace(joint, dofs=_dofs_with_values(joint.dofs, values)) for joint in robot.joints)
    loops = tuple(replace(loop, dofs=_dofs_with_values(loop.dofs, values)) for loop in robot.loops)
    return replace(robot, joints=joints, loops=loops)


def _dofs_with_values(dofs: Iterable[Dof], values: Mapping[str, Mapping[str, float]]) -> tuple[Dof, ...]:
    return tuple(
        replace(dof, dynamics=replace(dof.dynamics, **values[dof.name])) if dof.name in values else dof
        for dof in dofs
    )
