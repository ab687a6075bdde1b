"""Defines the settings by which a configuration steers the checks."""

from collections.abc import Mapping
from dataclasses import dataclass

from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.text.globs import no_match_hint


@dataclass(frozen=True, slots=True)
class CheckOptions:
    """The settings of a configuration for the checks."""

    strict: bool = False
    """Whether the checks may run longer simulations."""

    payload: tuple[tuple[str, float], ...] = ()
    """Links or frames, each with the mass [kg] that it must carry in addition to the robot's own."""


DEFAULT_OPTIONS = CheckOptions()


def known_payload(robot: Robot, payload: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
    """Returns the payload [kg] by link or frame. Raises ConfigError if the robot lacks a link or frame."""
    links, frames = [link.name for link in robot.links], [frame.name for frame in robot.frames]
    for name in payload:
        if name not in (*links, *frames):
            hint = no_match_hint(name, {"links": links, "frames": frames})
            raise ConfigError("the robot has no link or frame of this name", f"validate.payload.{name}", hint)
    return tuple(payload.items())
