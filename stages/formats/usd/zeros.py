"""Where the ball joints of a USD are at zero."""

import math

from linkwright.stages.robot.model.robot import Configuration, Robot, Value

_ROUNDING = 1e-12


def ball_zeros(robot: Robot, home: Configuration) -> dict[str, Value]:
    """Where the joints of balls are at zero that do not count from the robot's own: at `home`, since engines
    know the state of turns and slides alone, and start every ball at its zero. The cone of a ball has a
    middle that must stay."""
    balls = [dof for dof in robot.dofs if dof.kind == "ball" and dof.limits.upper is None]
    return {dof.name: home[dof.name] for dof in balls if is_turned(home[dof.name])}


def is_turned(value: Value) -> bool:
    """Whether a ball is not at rest at this value."""
    return isinstance(value, tuple) and math.hypot(*value[1:]) > _ROUNDING
