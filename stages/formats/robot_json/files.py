"""Defines the tables of robot.json about the robot's other files: their order, names and packages."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from linkwright.stages.formats.robot_json.codec import UNREAD, JsonRecord, Key
from linkwright.stages.formats.robot_json.values import DofName, ExactValue, LinkName, Pose, ShortRange, short
from linkwright.stages.robot.motion.linear_coupling import LinearCoupling


@dataclass(frozen=True)
class LoweredRecord(JsonRecord[None]):
    """A joint of the robot that is several joints in the URDF.

    joint: the joint.
    joints: the joints that represent it, from parent to child.
    links: the links between them.
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
    offset: the value that is added [rad or m].
    range: the driver's values between which the coupling was measured [rad or m].
    error: the largest error of the follower while the driver is in the range [rad or m].
    mimic: whether the coupling is exact, and therefore in the URDF.
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
        """Returns the record of a coupling: an exact coupling has the numbers of its <mimic>, others rounded
        ones."""
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
    """A link that is merged into another link in a format.

    link: the link.
    into: the link that contains it.
    pose: its pose in that link.
    """

    link: LinkName
    into: LinkName
    pose: Annotated[Pose, UNREAD]


@dataclass(frozen=True)
class UrdfRecord(JsonRecord[None]):
    """How the URDF names its meshes.

    package: the package that contains the meshes.
    """

    package: str


@dataclass(frozen=True)
class MjcfJointRow(JsonRecord[None]):
    """A joint of the MJCF.

    name: the name; null without a name.
    kind: the kind of its degree of freedom.
    unit: the unit of its numbers in `qpos`.
    qpos: the index of its first number in MuJoCo's array, and the number of its numbers.
    dof: the index of its first number in MuJoCo's array `qvel`, and the number of its numbers.
    urdf: the joints of the URDF that represent it, from parent to child.
    cad: the name of its mate in CAD; null without a mate.
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

    name: the name; null without a name.
    ctrl: the index of its first number in MuJoCo's array, and the number of its numbers.
    type: its tag.
    joint: the joint that it drives; null without a joint.
    unit: the unit of its control; null if it is unknown.
    range: the range of its control; null if it has no range, or the file does not compile.
    cad: the name of the joint's mate in CAD; null without a mate.
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

    name: the name; null without a name.
    index: its index among the sensors.
    type: its tag.
    on: the element that it measures; null without an element.
    address: the index of its first number in `sensordata`; null after a sensor with an unknown number of
        values.
    dim: the number of its values; null if it is unknown.
    unit: the unit of its numbers; null if it is unknown.
    cad: the name of the mate of its joint in CAD; null without a mate.
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
    """Elements of the MJCF, in its order.

    joints: the joints of the robot, and the joints of the user's own XML.
    actuators: the actuators of the robot, and the actuators of the user's own XML.
    sensors: the sensors of the robot, and the sensors of the user's own XML.
    """

    joints: tuple[MjcfJointRow, ...]
    actuators: tuple[MjcfActuatorRow, ...]
    sensors: tuple[MjcfSensorRow, ...]


@dataclass(frozen=True)
class UrdfJointRow(JsonRecord[None]):
    """A joint of the URDF that moves.

    name: its name.
    index: its index among the moving joints of the file.
    tree: its index among the moving joints in a walk down the tree, depth first and siblings by name, as in
        Pinocchio; null if the walk does not reach it.
    type: the type in the URDF.
    unit: the unit of its value.
    follows: the joint that it mimics; null without a mimic.
    dof: the robot's degree of freedom; null if it has none.
    cad: the name of its mate in CAD; null without a mate.
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
    """Elements of the URDF, in its order.

    joints: joints that move.
    """

    joints: tuple[UrdfJointRow, ...]


@dataclass(frozen=True)
class OrderRecord(JsonRecord[None]):
    """The order of things in the files.

    mjcf: present if an MJCF is written.
    urdf: present if a URDF is written.
    """

    mjcf: MjcfOrderRecord | None = None
    urdf: UrdfOrderRecord | None = None


@dataclass(frozen=True)
class VariedRecord(JsonRecord[None]):
    """A quantity that varies.

    quantity: its name: the link, joint or actuator, and the quantity.
    origin: where its value comes from.
    share: the share of the value by which it varies in both directions.
    """

    quantity: str
    origin: str
    share: float


@dataclass(frozen=True)
class VariantsRecord(JsonRecord[None]):
    """Robots that differ slightly from the robot, as arrays over the fields of the MJCF's model.

    file: the file with the arrays.
    n: the number of variants.
    seed: the seed of the random numbers.
    fields: MuJoCo's fields that vary.
    varied: the quantities that vary, and by how much.
    """

    file: str
    n: int
    seed: int
    fields: tuple[str, ...]
    varied: tuple[VariedRecord, ...]


@dataclass(frozen=True)
class SrdfRecord(JsonRecord[None]):
    """Content that only the SRDF has.

    never: link of the URDF → the later links that it never meets.
    end_effectors: the names of the end effectors.
    """

    never: Mapping[str, tuple[str, ...]]
    end_effectors: tuple[str, ...]


@dataclass(frozen=True)
class RenamedRecord(JsonRecord[None]):
    """Names of the robot → names in the format, if they differ; in ROS 2, the names of the URDF → names in
    ROS 2.

    links: names of links.
    joints: names of joints, by their degrees of freedom, also of loops.
    frames: names of frames, in an SDF.
    """

    links: Mapping[str, str]
    joints: Mapping[str, str]
    frames: Mapping[str, str] | None = None

    @classmethod
    def from_model(cls, value: Any, **more: Any) -> "RenamedRecord":
        """Returns the record of the names of a format, by the robot's names."""
        kinds = [kind for kind in ("links", "joints", "frames") if hasattr(value, kind)]
        return cls(**{kind: _changed(getattr(value, kind)) for kind in kinds})


def _changed(names: Mapping[str, str]) -> dict[str, str]:
    return {name: format_name for name, format_name in names.items() if name != format_name}


@dataclass(frozen=True)
class FormatRecord(JsonRecord[None]):
    """Differences between a format and the robot.

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
    folder: the folder in it with the robot's files; missing if it has no copies of them.
    renamed: names that are not the URDF's, in ROS 2.
    """

    package: str
    writer: int = 0
    folder: str = ""
    renamed: Annotated[RenamedRecord | None, UNREAD] = None
