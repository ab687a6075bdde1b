"""Derives the control range of an actuator that has none from its dof or its motor."""

import math
from collections.abc import Mapping
from typing import Any

from linkwright.stages.robot.dynamics.holding_control import holding_control
from linkwright.stages.robot.model.actuation import Actuator
from linkwright.stages.robot.model.robot import Dof, Value


def control_range(dof: Dof, actuator: Actuator, parameters: Mapping[str, Any]) -> tuple[float, float] | None:
    """Returns the control range that follows from the dof's limits, velocity or effort, or from the nominal
    voltage of a DC motor; None if there is no bound. A damper's is [0, 1], since MuJoCo requires a range: its
    control scales the damping."""
    gear = actuator.gear
    if actuator.type == "damper":
        return 0.0, 1.0
    if actuator.type in ("position", "pid"):
        low, high = dof.limits.mapped(gear).interval
        return None if math.isinf(low) or math.isinf(high) or low == high else (low, high)
    largest = _max_dof_bound(dof, actuator.type, parameters)
    if largest is None:
        return None
    # The force at the dof is gear times the control, the actuator's speed is gear times the dof's, and a
    # voltage is not geared.
    largest *= {"motor": 1.0 / abs(gear), "dcmotor": 1.0}.get(actuator.type, abs(gear))
    return -largest, largest


def with_keyframe_targets(
    limits: tuple[float, float] | None, dof: Dof, actuator: Actuator, values: Mapping[str, Value]
) -> tuple[float, float] | None:
    """Returns a servo's control range, widened to the targets that hold the dof in its keyframes; the range
    of another actuator as it is. At the end of the dof's limits such a target lies beyond them, because a
    servo sags under load."""
    if limits is None or actuator.type not in ("position", "pid"):
        return limits
    low, high = limits
    for keyframe, value in values.items():
        if not isinstance(value, tuple) and dof.limits.contains(value):
            target = holding_control(actuator, value, actuator.force_at(keyframe))
            low, high = min(low, target), max(high, target)
    return low, high


def _max_dof_bound(dof: Dof, actuator_type: str, parameters: Mapping[str, Any]) -> float | None:
    """Returns the dof's velocity [rad/s or m/s] or effort [N m or N], or the nominal voltage [V] of a DC
    motor, whichever bounds the control of this type; None without a bound."""
    if actuator_type in ("velocity", "intvelocity"):
        return dof.dynamics.velocity
    if actuator_type == "motor":
        return dof.dynamics.effort
    if actuator_type == "dcmotor":
        return float(parameters["nominal"][0]) if "nominal" in parameters else None
    return None
