"""Reads the gravity against which actuators hold a robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from linkwright.stages.robot.dynamics.statics import GRAVITY

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.mujoco_section import OptionSection


def gravity_of(option: OptionSection) -> tuple[float, ...]:
    """Returns the gravity (3,) [m/s²] in the world's frame. `option`: the keys `scene.option`, whose flag may
    disable gravity."""
    if option.sections()["flag"].explicit().get("gravity") == "disable":
        return (0.0, 0.0, 0.0)
    return tuple(option.explicit().get("gravity", GRAVITY))
