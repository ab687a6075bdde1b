"""The robot as it is built: with what its motors give the dofs, and the armatures that were added."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from linkwright.stages.robot.model.actuation import Actuation, Supplied
from linkwright.stages.robot.model.robot import Dof, Robot


def as_driven(robot: Robot, actuation: Actuation) -> Robot:
    """The robot whose dofs have what `actuation` gives them."""
    added = [(one.dof, one.quantity, one.value) for one in actuation.supplied]
    return _with(robot, [*added, *((one.dof, "armature", one.value) for one in actuation.armatures)])


def with_motors(robot: Robot, supplied: Iterable[Supplied]) -> Robot:
    """The robot whose dofs have what motors give them."""
    return _with(robot, [(one.dof, one.quantity, one.value) for one in supplied])


def _with(robot: Robot, added: Iterable[tuple[str, str, float]]) -> Robot:
    """`added`: (dof, quantity of its dynamics, value)."""
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
