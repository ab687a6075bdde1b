"""Defines the actuators and sensors of robot.json."""

from dataclasses import dataclass
from typing import Annotated, Any

from linkwright.stages.formats.robot_json.codec import UNREAD, JsonRecord, Key, PairRecord
from linkwright.stages.formats.robot_json.values import (
    Coordinate,
    DofName,
    Forces,
    LinkName,
    Number,
    Pose,
    Range,
    SixDigits,
    Sizes,
    TextPairs,
)
from linkwright.stages.robot.model.actuation import Actuation, Actuator, ActuatorType, Armature
from linkwright.stages.robot.model.sensing import (
    Sensing,
    Sensor,
    SensorCamera,
    SensorSite,
    SensorTarget,
    ZoneShape,
)


@dataclass(frozen=True, kw_only=True)
class ActuatorRecord(JsonRecord[Actuator]):
    """An actuator of a degree of freedom.

    name: unique among actuators.
    dof: the degree of freedom that it drives.
    type: the type in MuJoCo; general has all its parameters in `terms`.
    gear: length of the actuator per value of the degree of freedom.
    kp: a servo's stiffness [N m/rad or N/m]; null for other actuators.
    kv: a servo's damping [N m s/rad or N s/m]; null for other actuators.
    terms: MJCF's other attributes.
    control: the lowest and the highest control, in the unit of the type; null without limits.
    force: the lowest and the highest force at the actuator [N m or N]; null without limits.
    home: the control at the keyframe `home`.
    load: the largest force at the degree of freedom by the robot's weight, over its range [N m or N]; null if
        it is unknown.
    home_load: the force at the degree of freedom by the robot's weight at `home` [N m or N]; null if it is
        unknown.
    holds: keyframe that needs one → the force at the degree of freedom, with its sign, that holds the robot
        there [N m or N].
    sag: how far the robot's weight moves the servo's degree of freedom from a target at `home` [rad or m].
    estimated: the values that Linkwright chose.
    motor: a motor of the library; missing without a motor.
    provenance: parameter of the motor → where its value comes from.
    """

    name: str
    dof: DofName
    type: ActuatorType
    gear: Number
    kp: Number | None
    kv: Number | None
    terms: TextPairs = ()
    control: Range | None
    force: Range | None
    home: Coordinate
    load: SixDigits | None
    home_load: Annotated[SixDigits | None, UNREAD]
    holds: Forces = ()
    sag: Annotated[SixDigits | None, UNREAD]
    estimated: tuple[str, ...]
    motor: str = ""
    sources: Annotated[TextPairs, Key("provenance")] = ()


@dataclass(frozen=True)
class ArmatureRecord(JsonRecord[Armature]):
    """An inertia that Linkwright adds to a degree of freedom that has none.

    dof: the degree of freedom.
    value: the inertia [kg m² or kg].
    reason: the reason, in words.
    """

    dof: DofName
    value: Number
    reason: str


@dataclass(frozen=True)
class CompensatedRecord(PairRecord):
    """A link whose weight actuators carry.

    link: the link.
    share: the share of the link's weight.
    """

    link: LinkName
    share: Number


@dataclass(frozen=True)
class ActuationRecord(JsonRecord[Actuation]):
    """The actuators of the robot, and the values that belong to them.

    actuators: actuators in the order of the degrees of freedom.
    armatures: inertias that Linkwright adds.
    compensated: the links whose weight actuators carry.
    compensating: the degrees of freedom whose actuators carry the weight of `compensated` links.
    """

    actuators: tuple[ActuatorRecord, ...] = ()
    armatures: tuple[ArmatureRecord, ...] = ()
    compensated: tuple[CompensatedRecord, ...] = ()
    compensating: tuple[str, ...] = ()


@dataclass(frozen=True)
class SensorEndRecord(PairRecord):
    """The object that a sensor is on, or in whose frame it measures.

    kind: the kind of object; body is a link's centre of mass, xbody its frame.
    name: the name of a degree of freedom, an actuator, a frame, a link or a camera.
    """

    kind: SensorTarget
    name: str


@dataclass(frozen=True)
class SensorRecord(JsonRecord[Sensor]):
    """A sensor.

    name: unique among sensors.
    type: the type in MJCF.
    on: the object of the sensor; null for the whole model.
    relative_to: the frame in which a sensor measures another frame, or the camera in whose image it measures;
        null for other sensors.
    noise: standard deviation, in the unit of the sensor.
    cutoff: the largest value, in the unit of the sensor; 0 without a limit.
    shape: the shape in which a sensor of the source feels contact.
    size: the size of that shape [m], as in `sensor_sites`.
    """

    name: str
    type: str
    on: SensorEndRecord | None
    relative_to: SensorEndRecord | None
    noise: Number
    cutoff: Number
    shape: ZoneShape = ""
    size: Sizes = ()

    @classmethod
    def from_model(cls, value: Sensor, **more: Any) -> "SensorRecord":
        target = (value.target, value.name_of_target) if value.target else None
        reference = (value.relative_to, value.name_of_relative) if value.relative_to else None
        # The size belongs to a shape.
        size = value.size if value.shape else ()
        return super().from_model(value, on=target, relative_to=reference, size=size)

    def to_model(self, **more: Any) -> Sensor:
        target, target_name = self.on.to_model() if self.on else ("", "")
        reference, reference_name = self.relative_to.to_model() if self.relative_to else ("", "")
        return super().to_model(
            target=target,
            name_of_target=target_name,
            relative_to=reference,
            name_of_relative=reference_name,
        )


@dataclass(frozen=True)
class SensorSiteRecord(JsonRecord[SensorSite]):
    """A place on a link that only sensors use.

    name: unique among sites.
    link: the link that has it.
    pose: its pose in the link.
    shape: the shape in which contact is felt; null for a point.
    size: of the shape [m]: the radius of a sphere; the radius and the length of a cylinder or capsule; the
        lengths along x, y and z of a box or ellipsoid; null for a point.
    """

    name: str
    link: LinkName
    link_from_site: Pose
    shape: ZoneShape | None
    size: Sizes | None

    @classmethod
    def from_model(cls, value: SensorSite, **more: Any) -> "SensorSiteRecord":
        return super().from_model(value, shape=value.shape or None, size=value.size if value.shape else None)

    def to_model(self, **more: Any) -> SensorSite:
        return super().to_model(shape=self.shape or "", size=self.size or ())


@dataclass(frozen=True)
class SensorCameraRecord(JsonRecord[SensorCamera]):
    """A camera that the robot carries. It looks along z, x to the right, y down.

    name: unique among cameras.
    link: the link that has it.
    pose: its pose in the link.
    fovy: its vertical field of view [deg].
    resolution: width and height [pixels].
    """

    name: str
    link: LinkName
    link_from_camera: Pose
    fovy: Number
    resolution: tuple[int, int]


@dataclass(frozen=True)
class SensingRecord(JsonRecord[Sensing]):
    """The sensors and cameras of the robot.

    sensors: sensors in the order of MuJoCo's `sensordata`.
    sensor_sites: places on links that only sensors use.
    cameras: cameras that the robot carries.
    """

    sensors: tuple[SensorRecord, ...] = ()
    sites: Annotated[tuple[SensorSiteRecord, ...], Key("sensor_sites")] = ()
    cameras: tuple[SensorCameraRecord, ...] = ()
