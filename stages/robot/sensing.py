"""What measures a robot: sensors, in the words of MJCF."""

from dataclasses import dataclass
from typing import Literal

SensorTarget = Literal["", "joint", "actuator", "site", "body", "xbody"]
"""What a sensor is on; "" for the whole model. body: a link's centre of mass; xbody: its frame."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor of MJCF's `type`, on the `target` of that `name_of_target`: a dof, an actuator, a frame or a
    link. `relative_to`: likewise, of a sensor of a frame in another. `noise`: standard deviation; `cutoff`:
    the largest value, 0 for none; both in the unit of the sensor."""

    name: str
    type: str
    target: SensorTarget = ""
    name_of_target: str = ""
    relative_to: SensorTarget = ""
    name_of_relative: str = ""
    noise: float = 0.0
    cutoff: float = 0.0
