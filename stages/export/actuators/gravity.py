"""The gravity that actuators hold a robot against."""

from typing import Any

from linkwright.stages.robot.dynamics.statics import GRAVITY


def gravity_of(option: Any) -> tuple[float, ...]:
    """In the world (3,) [m/s²], by the keys `scene.option`; zero where its flag is off."""
    if option.sections()["flag"].given().get("gravity") == "disable":
        return (0.0, 0.0, 0.0)
    return tuple(option.given().get("gravity", GRAVITY))
