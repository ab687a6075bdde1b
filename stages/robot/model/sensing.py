"""What measures a robot: sensors, in the words of MJCF, and the places and cameras that they need."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from linkwright.stages.robot.model.arrays import Array

SensorTarget = Literal["", "joint", "actuator", "site", "body", "xbody", "camera"]
"""What a sensor is on; "" for the whole model. body: a link's centre of mass; xbody: its frame."""


ZoneShape = Literal["", "sphere", "capsule", "ellipsoid", "cylinder", "box"]
"""The shape inside which contact is felt; "" for a point."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor of MJCF's `type`, on the `target` of that `name_of_target`: a dof, an actuator, a frame or a
    link. `relative_to`: likewise, of a sensor of a frame in another, and of one in the image of a camera.
    `noise`: standard deviation; `cutoff`: the largest value, 0 for none; both in the unit of the sensor.
    `shape` and `size`: as of a `SensorSite`, of one that the source has."""

    name: str
    type: str
    target: SensorTarget = ""
    name_of_target: str = ""
    relative_to: SensorTarget = ""
    name_of_relative: str = ""
    noise: float = 0.0
    cutoff: float = 0.0
    shape: ZoneShape = ""
    size: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class SensorSite:
    """A place on a link that is there for a sensor alone. `size` [m]: of the `shape` around it, inside which
    contact is felt: (radius,) of a sphere, (radius, length) of a cylinder or capsule, lengths along x, y and
    z of a box or ellipsoid."""

    name: str
    link: str
    link_from_site: "Array"
    shape: ZoneShape = ""
    size: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class SensorCamera:
    """A camera on a link, which looks along its z axis, with x to the right and y down in the image. `fovy`:
    vertical field of view [deg]; `resolution`: width and height [pixels]."""

    name: str
    link: str
    link_from_camera: "Array"
    fovy: float
    resolution: tuple[int, int]


@dataclass(frozen=True, slots=True)
class Sensing:
    """All sensors of a robot, in the order of MuJoCo's `sensordata`, with their places and cameras."""

    sensors: tuple[Sensor, ...] = ()
    sites: tuple[SensorSite, ...] = ()
    cameras: tuple[SensorCamera, ...] = ()


NOTHING = Sensing()
"""Nothing measures the robot."""
