"""Describes the sensors of a robot, in MJCF's terms, and the sites and cameras that they need."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from linkwright.stages.robot.model.arrays import Array

SensorTarget = Literal["", "joint", "actuator", "site", "body", "xbody", "camera"]
"""The kind of a sensor's object; "" for the whole model. body: a link's centre of mass; xbody: its frame."""


ZoneShape = Literal["", "sphere", "capsule", "ellipsoid", "cylinder", "box"]
"""The shape inside which contact is felt; "" for a point."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor of MJCF's `type`."""

    name: str
    type: str
    target: SensorTarget = ""
    """Kind of the object that it measures."""
    name_of_target: str = ""
    """Name of that object: a dof, an actuator, a link, a frame, a place in `Sensing.sites` or a
    camera."""
    relative_to: SensorTarget = ""
    """Kind of a second object, for a frame's sensor in another frame or in a camera's image."""
    name_of_relative: str = ""
    """Name of the second object."""
    noise: float = 0.0
    """Standard deviation, in the unit of the sensor."""
    cutoff: float = 0.0
    """Largest value, in the unit of the sensor; 0 for none."""
    shape: ZoneShape = ""
    """Zone in which contact is felt, of a sensor of an MJCF source; as in `SensorSite`."""
    size: tuple[float, ...] = ()
    """Size of that zone [m], as in `SensorSite`."""


@dataclass(frozen=True, slots=True, eq=False)
class SensorSite:
    """A place on a link that exists only for a sensor."""

    name: str
    link: str
    link_from_site: "Array"
    shape: ZoneShape = ""
    """The shape around it inside which contact is felt."""
    size: tuple[float, ...] = ()
    """Size of the shape [m]: (radius,) of a sphere, (radius, length) of a cylinder or capsule, lengths along
    x, y and z of a box or ellipsoid."""


@dataclass(frozen=True, slots=True, eq=False)
class SensorCamera:
    """A camera on a link, which looks along its z axis, with x to the right and y down in the image."""

    name: str
    link: str
    link_from_camera: "Array"
    fovy: float
    """Vertical field of view [deg]."""
    resolution: tuple[int, int]
    """Width and height [pixels]."""


@dataclass(frozen=True, slots=True)
class Sensing:
    """All sensors of a robot, in the order of MuJoCo's `sensordata`, with their places and cameras."""

    sensors: tuple[Sensor, ...] = ()
    sites: tuple[SensorSite, ...] = ()
    cameras: tuple[SensorCamera, ...] = ()


NOTHING = Sensing()
"""Nothing measures the robot."""
