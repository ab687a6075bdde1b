"""What a robot.json says of the robot's other files: their order, their names, and packages of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from linkwright.stages.formats.robot_json.codec import UNREAD, JsonRecord, Key
from linkwright.stages.formats.robot_json.values import DofName, ExactValue, LinkName, Pose, ShortRange, short
from linkwright.stages.robot.motion.linear_coupling import LinearCoupling


@dataclass(frozen=True)
class LoweredRecord(JsonRecord[None]):
    """A joint that is several joints in the URDF.

    joint: the joint.
    joints: those that stand for it, from parent to child.
    links: those between them.
    """

    joint: str
    joints: tuple[str, ...]
    links: tuple[str, ...]


@dataclass(frozen=True)
class CouplingRecord(JsonRecord[LinearCoupling]):
    """A degree of freedom that closed loops make follow another: follower = multiplier · driver + offset.

    follower: the degree of freedom that follows.
    driver: the degree of freedom that is followed.
    multiplier: factor of the driver's value.
    offset: what is added [rad or m].
    range: the driver's values between which that was found [rad or m].
    error: how far the follower is off at most where the driver is in the range [rad or m].
    mimic: whether that is exact, and so in the URDF.
    """

    follower: DofName
    driver: DofName
    multiplier: float
    offset: float
    range: ShortRange
    error: float
    exact: Annotated[bool, Key("mimic")]

    @classmethod
    def from_model(cls, value: LinearCoupling, **more: Any) -> "CouplingRecord":
        """An exact one with the numbers of its <mimic>; those of another one are fitted."""
        numbers = (
            {}
            if value.exact
            else {key: short(getattr(value, key)) for key in ("multiplier", "offset", "error")}
        )
        return super().from_model(value, range=(value.low, value.high), **{"error": 0.0, **numbers})

    def to_model(self, **more: Any) -> LinearCoupling:
        low, high = self.range
        return super().to_model(low=low, high=high)


@dataclass(frozen=True)
class HeldRecord(JsonRecord[None]):
    """A link that is part of another in a format.

    link: the link.
    into: the link that it is part of.
    pose: where it is in that.
    """

    link: LinkName
    into: LinkName
    pose: Annotated[Pose, UNREAD]


@dataclass(frozen=True)
class UrdfRecord(JsonRecord[None]):
    """How the URDF names its meshes.

    package: the package that has them.
    """

    package: str


@dataclass(frozen=True)
class MjcfJointRow(JsonRecord[None]):
    """A joint of the MJCF.

    name: null for none.
    kind: that of its degree of freedom.
    unit: of its numbers in `qpos`.
    qpos: its first number in MuJoCo's array, and how many it has.
    dof: its first number in MuJoCo's array `qvel`, and how many it has.
    urdf: the joints of the URDF that stand for it, from parent to child.
    cad: what CAD calls its mate; null for none.
    """

    name: str | None
    kind: str
    unit: str
    qpos: tuple[int, int]
    dof: tuple[int, int]
    urdf: tuple[str, ...]
    cad: str | None


@dataclass(frozen=True)
class MjcfActuatorRow(JsonRecord[None]):
    """An actuator of the MJCF.

    name: null for none.
    ctrl: its first number in MuJoCo's array, and how many it has.
    type: its tag.
    joint: the joint that it drives; null for none.
    unit: of its control; null where it is unknown.
    range: of its control; null where it has none, or the file has none that compiles.
    cad: what CAD calls the joint's mate; null for none.
    """

    name: str | None
    ctrl: tuple[int, int]
    type: str
    joint: str | None
    unit: str | None
    range: tuple[float, ...] | None
    cad: str | None


@dataclass(frozen=True)
class MjcfSensorRow(JsonRecord[None]):
    """A sensor of the MJCF.

    name: null for none.
    index: its place among the sensors.
    type: its tag.
    on: what it is on; null for nothing.
    address: its first number in `sensordata`; null after a sensor whose numbers are not known.
    dim: how many numbers it has; null where that is not known.
    unit: of its numbers; null where it is not known.
    cad: what CAD calls the mate of its joint; null for none.
    """

    name: str | None
    index: int
    type: str
    on: str | None
    address: int | None
    dim: int | None
    unit: str | None
    cad: str | None


@dataclass(frozen=True)
class MjcfOrderRecord(JsonRecord[None]):
    """What is in the MJCF, in its order.

    joints: those of the robot, and those of the user's own XML.
    actuators: likewise.
    sensors: likewise.
    """

    joints: tuple[MjcfJointRow, ...]
    actuators: tuple[MjcfActuatorRow, ...]
    sensors: tuple[MjcfSensorRow, ...]


@dataclass(frozen=True)
class UrdfJointRow(JsonRecord[None]):
    """A joint of the URDF that moves.

    name: its name.
    index: its place among those that move in the file.
    tree: its place among those that move in a walk down the tree, depth first and siblings by name, as
        Pinocchio has them; null where the walk does not reach it.
    type: that of the URDF.
    unit: of its value.
    follows: the joint that it mimics; null for none.
    dof: the robot's degree of freedom; null for none.
    cad: what CAD calls its mate; null for none.
    """

    name: str | None
    index: int
    tree: int | None
    type: str
    unit: str
    follows: str | None
    dof: str | None
    cad: str | None


@dataclass(frozen=True)
class UrdfOrderRecord(JsonRecord[None]):
    """What is in the URDF, in its order.

    joints: those that move.
    """

    joints: tuple[UrdfJointRow, ...]


@dataclass(frozen=True)
class OrderRecord(JsonRecord[None]):
    """The order of things in the files.

    mjcf: present where an MJCF is written.
    urdf: present where a URDF is written.
    """

    mjcf: MjcfOrderRecord | None = None
    urdf: UrdfOrderRecord | None = None


@dataclass(frozen=True)
class SrdfRecord(JsonRecord[None]):
    """What only the SRDF says.

    never: link of the URDF → the later ones that it never meets.
    end_effectors: their names.
    """

    never: Mapping[str, tuple[str, ...]]
    end_effectors: tuple[str, ...]


@dataclass(frozen=True)
class RenamedRecord(JsonRecord[None]):
    """The robot's names → those in the format, where these differ; in ROS 2, the URDF's names.

    links: of links.
    joints: of joints, by their degrees of freedom, also of loops.
    frames: of frames, in an SDF.
    """

    links: Mapping[str, str]
    joints: Mapping[str, str]
    frames: Mapping[str, str] | None = None

    @classmethod
    def from_model(cls, value: Any, **more: Any) -> "RenamedRecord":
        """Of all names of a format by the robot's."""
        kinds = [kind for kind in ("links", "joints", "frames") if hasattr(value, kind)]
        return cls(**{kind: _changed(getattr(value, kind)) for kind in kinds})


def _changed(names: Mapping[str, str]) -> dict[str, str]:
    return {name: own for name, own in names.items() if name != own}


@dataclass(frozen=True)
class FormatRecord(JsonRecord[None]):
    """What a format has otherwise than the robot.

    renamed: names that are not the robot's.
    zeros: degree of freedom → its value where its joint of the format is at 0, unless that is 0. A ball's
        joint turns on from that pose.
    """

    renamed: RenamedRecord | None = None
    zeros: Mapping[str, ExactValue] | None = None


@dataclass(frozen=True)
class PackageRecord(JsonRecord[None]):
    """A package that is written from the other files.

    package: its name.
    writer: the version of its writer; missing in an older build.
    folder: that of the robot's files in it; missing where it has no copies of them.
    renamed: names that are not the URDF's, in ROS 2.
    """

    package: str
    writer: int = 0
    folder: str = ""
    renamed: Annotated[RenamedRecord | None, UNREAD] = None
