"""What a configuration asks of the checks."""

from collections.abc import Mapping
from dataclasses import dataclass

from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.text.globs import there_are


@dataclass(frozen=True, slots=True)
class Asked:
    """`strict`: the checks may take their time; `payload`: (link or frame, mass [kg]) that the robot shall
    carry beside its own weight."""

    strict: bool = False
    payload: tuple[tuple[str, float], ...] = ()


AS_STANDARD = Asked()


def known_payload(robot: Robot, payload: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
    """The payload [kg] by link or frame. ConfigError where the robot has none of that name."""
    links, frames = [link.name for link in robot.links], [frame.name for frame in robot.frames]
    for name in payload:
        if name not in (*links, *frames):
            hint = there_are(name, {"links": links, "frames": frames})
            raise ConfigError("the robot has no link or frame of this name", f"validate.payload.{name}", hint)
    return tuple(payload.items())
