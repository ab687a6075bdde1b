"""Finds the zeros of the ball joints of a USD."""

import math

from linkwright.stages.robot.model.robot import Configuration, Robot, Value

_TURN_TOLERANCE = 1e-12
"""Length of a quaternion's vector part up to which a ball is not turned."""


def ball_zeros(robot: Robot, home: Configuration) -> dict[str, Value]:
    """Returns, by dof, the values at which ball joints have their zeros in the USD, if these differ from the
    robot's zeros.

    They are the values at `home`: engines know only the state of turns and slides, and start every ball at
    its zero. Balls with cones keep the robot's zero, as the middle of a cone must stay.
    """
    balls = [dof for dof in robot.dofs if dof.kind == "ball" and dof.limits.upper is None]
    return {dof.name: home[dof.name] for dof in balls if is_turned(home[dof.name])}


def is_turned(value: Value) -> bool:
    """Tells whether a ball is turned at this value."""
    return isinstance(value, tuple) and math.hypot(*value[1:]) > _TURN_TOLERANCE
