"""The range of a control that nobody gave."""

import math
from collections.abc import Mapping
from typing import Any

from stages.robot.actuation import Actuator
from stages.robot.model import Dof


def control_range(dof: Dof, made: Actuator, given: Mapping[str, Any]) -> tuple[float, float] | None:
    """The range that the dof's limits, velocity or effort, or the voltage of a DC motor, ask for; None where
    that is open. A damper's is [0, 1], the share of its damping, since MuJoCo demands one."""
    gear = made.gear
    if made.type == "damper":
        return 0.0, 1.0
    if made.type in ("position", "pid"):
        low, high = sorted(gear * end for end in dof.limits.interval)
        return None if math.isinf(low) or math.isinf(high) or low == high else (low, high)
    most = _most(dof, made.type, given)
    if most is None:
        return None
    most *= {"motor": 1.0 / abs(gear), "dcmotor": 1.0}.get(made.type, abs(gear))
    return -most, most


def _most(dof: Dof, kind: str, given: Mapping[str, Any]) -> float | None:
    if kind in ("velocity", "intvelocity"):
        return dof.dynamics.velocity
    if kind == "motor":
        return dof.dynamics.effort
    if kind == "dcmotor":
        return float(given["nominal"][0]) if "nominal" in given else None
    return None
