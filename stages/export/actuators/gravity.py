"""Reads the gravity against which actuators hold a robot."""

from typing import Any

from linkwright.stages.robot.dynamics.statics import GRAVITY


def gravity_of(option: Any) -> tuple[float, ...]:
    """Returns the gravity in the world (3,) [m/s²] of the keys `scene.option`; zero if its flag disables
    it."""
    if option.sections()["flag"].explicit().get("gravity") == "disable":
        return (0.0, 0.0, 0.0)
    return tuple(option.explicit().get("gravity", GRAVITY))
