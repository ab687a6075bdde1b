"""Defines the tables of robot.json about the other files: the names and the order of their elements,
packages, variants."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from linkwright.stages.formats.robot_json import values
from linkwright.stages.formats.robot_json.codec import UNREAD, JsonRecord, Key
from linkwright.stages.formats.robot_json.values import DofName, ExactValue, LinkName, Pose
from linkwright.stages.robot.motion.linear_coupling import LinearCoupling


@dataclass(frozen=True)
class SplitJointRecord(JsonRecord[None]):
    """A joint of the robot that is several joints in the URDF.

    joint: the joint of the robot.
    joints: the joints of the URDF that represent it, from parent to child.
    links: the links between them.
    """

    joint: str
    joints: tuple[str, ...]
    links: tuple[str, ...]


@dataclass(frozen=True)
class CouplingRecord(JsonRecord[LinearCoupling]):
    """A degree of freedom that follows another because of closed loops: follower = multiplier · driver +
    offset.

    follower: the degree of freedom that follows.
    driver: the degree of freedom that it follows.
    multiplier: the factor of the driver's value.
    offset: the value that is added to the product [rad or m].
    range: the smallest and the largest value of the driver for which the coupling was measured [rad or m].
    error: the largest error of the follower while the driver is in the range [rad or m].
    mimic: whether the coupling is exact, and therefore in the URDF.
    """

    follower: DofName
    driver: DofName
    multiplier: float
    offset: float
    range: values.SixDigitRange
    error: float
    exact: Annotated[bool, Key("mimic")]

    @classmethod
    def from_model(cls, value: LinearCoupling, **more: Any) -> "CouplingRecord":
        """Returns the record of a coupling. The numbers of an exact coupling are those of its <mimic>; other
        couplings have rounded numbers."""
        numbers = {"error": 0.0}
        if not value.exact:
            keys = ("multiplier", "offset", "error")
            numbers = {key: values.six_digits(getattr(value, key)) for key in keys}
        return super().from_model(value, range=(value.low, value.high), **numbers)

    def to_model(self, **more: Any) -> LinearCoupling:
        low, high = self.range
        return super().to_model(low=low, high=high)


@dataclass(frozen=True)
class MergedLinkRecord(JsonRecord[None]):
    """A link that is merged into another link in a format.

    link: the merged link.
    into: the link that contains it in the format.
    pose: its pose in that link.
    """

    link: LinkName
    into: LinkName
    pose: Annotated[Pose, UNREAD]


@dataclass(frozen=True)
class UrdfPackageRecord(JsonRecord[None]):
    """The package in the URDF's paths of meshes.

    package: the name of the package.
    """

    package: str


@dataclass(frozen=True)
class MjcfJointRow(JsonRecord[None]):
    """A joint of the MJCF.

    name: the name; null without a name.
    kind: the kind of its degree of freedom.
    unit: the unit of its numbers in `qpos`.
    qpos: the index of its first number in MuJoCo's array `qpos`, and how many numbers it has there.
    dof: the index of its first number in MuJoCo's array `qvel`, and how many numbers it has there.
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
    ctrl: the index of its first number in MuJoCo's array `ctrl`, and how many numbers it has there.
    type: the tag of its element.
    joint: the joint that it drives; null if it drives no joint.
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
    type: the tag of its element.
    on: the element that it measures; null if it measures no element.
    address: the index of its first number in MuJoCo's array `sensordata`; null if an earlier sensor has an
        unknown number of values.
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
    """Elements of the MJCF in the order of the file.

    joints: the joints of the robot and of the user's own XML.
    actuators: the actuators of the robot and of the user's own XML.
    sensors: the sensors of the robot and of the user's own XML.
    """

    joints: tuple[MjcfJointRow, ...]
    actuators: tuple[MjcfActuatorRow, ...]
    sensors: tuple[MjcfSensorRow, ...]


@dataclass(frozen=True)
class UrdfJointRow(JsonRecord[None]):
    """A joint of the URDF that moves.

    name: its name.
    index: its index among the moving joints, in the order of the file.
    tree: its index among the moving joints in a walk down the tree, depth first and siblings by name, as in
        Pinocchio; null if the walk does not reach it.
    type: its type in the URDF.
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
    """Elements of the URDF in the order of the file.

    joints: the joints that move.
    """

    joints: tuple[UrdfJointRow, ...]


@dataclass(frozen=True)
class OrderRecord(JsonRecord[None]):
    """The order of elements in the MJCF and in the URDF.

    mjcf: the order in the MJCF; missing if no MJCF is written.
    urdf: the order in the URDF; missing if no URDF is written.
    """

    mjcf: MjcfOrderRecord | None = None
    urdf: UrdfOrderRecord | None = None


@dataclass(frozen=True)
class VariedQuantityRecord(JsonRecord[None]):
    """A quantity that varies between the variants of a robot.

    quantity: its full name, such as links.palm.mass.
    origin: where its value comes from.
    share: the largest change upwards or downwards, as a share of the value.
    """

    quantity: str
    origin: str
    share: float


@dataclass(frozen=True)
class VariantsRecord(JsonRecord[None]):
    """Variants of the robot, whose quantities differ slightly, as arrays of the fields of the MJCF's model.

    file: the name of the file with the arrays.
    n: the number of variants.
    seed: the seed of the random numbers.
    fields: the fields of MuJoCo's model that vary.
    varied: the quantities that vary, and by how much.
    """

    file: str
    n: int
    seed: int
    fields: tuple[str, ...]
    varied: tuple[VariedQuantityRecord, ...]


@dataclass(frozen=True)
class SrdfRecord(JsonRecord[None]):
    """Content of the SRDF that no other file has.

    never: link of the URDF → the links that it never collides with; each pair is listed once.
    end_effectors: the names of the end effectors.
    """

    never: Mapping[str, tuple[str, ...]]
    end_effectors: tuple[str, ...]


@dataclass(frozen=True)
class NameChangesRecord(JsonRecord[None]):
    """Names that a format changes, by the names in the robot; for ROS 2, by the names in the URDF.

    links: name of a link → its name in the format.
    joints: name of a degree of freedom → name of its joint in the format.
    frames: name of a frame → its name in the format; only for an SDF.
    """

    links: Mapping[str, str]
    joints: Mapping[str, str]
    frames: Mapping[str, str] | None = None

    @classmethod
    def from_model(cls, value: Any, **more: Any) -> "NameChangesRecord":
        """Returns the record of a format's names. `value` has the mapping of all names of each kind: `links`,
        `joints`, and `frames` if the format has frames."""
        kinds = [kind for kind in ("links", "joints", "frames") if hasattr(value, kind)]
        return cls(**{kind: _changed_names(getattr(value, kind)) for kind in kinds})


def _changed_names(names: Mapping[str, str]) -> dict[str, str]:
    return {name: format_name for name, format_name in names.items() if name != format_name}


@dataclass(frozen=True)
class FormatRecord(JsonRecord[None]):
    """Differences between a format and the robot.

    renamed: the names that differ from the robot's.
    zeros: degree of freedom → its value when its joint in the format is at 0, unless that value is 0; for a
        ball, the orientation from which the format counts the joint's rotation.
    """

    renamed: NameChangesRecord | None = None
    zeros: Mapping[str, ExactValue] | None = None


@dataclass(frozen=True)
class PackageRecord(JsonRecord[None]):
    """A package that is written from the other files.

    package: its name.
    writer: the version of its writer; missing in an older build.
    folder: the folder with the package's copies of the robot's files; missing without copies.
    renamed: the names that differ from the URDF's; only for ROS 2.
    """

    package: str
    writer: int = 0
    folder: str = ""
    renamed: Annotated[NameChangesRecord | None, UNREAD] = None
