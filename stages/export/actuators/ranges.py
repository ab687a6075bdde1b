"""The range of a control that nobody gave."""

import math
from collections.abc import Mapping
from typing import Any

from linkwright.stages.robot.dynamics.holding_control import control_at
from linkwright.stages.robot.model.actuation import Actuator
from linkwright.stages.robot.model.robot import Dof, Value


def control_range(dof: Dof, made: Actuator, given: Mapping[str, Any]) -> tuple[float, float] | None:
    """The range that the dof's limits, velocity or effort, or the voltage of a DC motor, ask for; None where
    that is open. A damper's is [0, 1], the share of its damping, since MuJoCo demands one."""
    gear = made.gear
    if made.type == "damper":
        return 0.0, 1.0
    if made.type in ("position", "pid"):
        low, high = dof.limits.mapped(gear).interval
        return None if math.isinf(low) or math.isinf(high) or low == high else (low, high)
    most = _most(dof, made.type, given)
    if most is None:
        return None
    most *= {"motor": 1.0 / abs(gear), "dcmotor": 1.0}.get(made.type, abs(gear))
    return -most, most


def widened(
    limits: tuple[float, float] | None, dof: Dof, made: Actuator, values: Mapping[str, Value]
) -> tuple[float, float] | None:
    """The range of a target with the targets that hold the dof at its values in keyframes, which at the end
    of its limits lie beyond these."""
    if limits is None or made.type not in ("position", "pid"):
        return limits
    low, high = limits
    for keyframe, value in values.items():
        if not isinstance(value, tuple) and dof.limits.contains(value):
            target = control_at(made, value, made.force_at(keyframe))
            low, high = min(low, target), max(high, target)
    return low, high


def _most(dof: Dof, kind: str, given: Mapping[str, Any]) -> float | None:
    if kind in ("velocity", "intvelocity"):
        return dof.dynamics.velocity
    if kind == "motor":
        return dof.dynamics.effort
    if kind == "dcmotor":
        return float(given["nominal"][0]) if "nominal" in given else None
    return None
