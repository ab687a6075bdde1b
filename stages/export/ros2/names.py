"""Makes names that ROS accepts: of packages, links, joints and sensors.

Topics and parameters contain the names of TF frames and of joints. In these, a point, a slash or a space has
a meaning of its own, and a word that begins with a digit is read as a number.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from linkwright.stages.export.package_names import stem_of
from linkwright.stages.robot.text.names import free_name, plain

XACRO_TAGS = frozenset(
    {"arg", "attribute", "call", "element", "if", "include", "insert_block", "macro", "property", "unless"}
)
"""Elements of xacro, whose names no macro can have."""


@dataclass(frozen=True, slots=True)
class RosNames:
    """The names in the package."""

    links: Mapping[str, str]
    """Link in the robot's own URDF → its name in the package."""

    joints: Mapping[str, str]
    """Joint in the robot's own URDF → its name in the package."""

    @property
    def renamed(self) -> dict[str, dict[str, str]]:
        """Returns the links and joints with another name in the package, by kind."""
        names_by_kind = {"links": self.links, "joints": self.joints}
        return {
            kind: {name: package_name for name, package_name in names.items() if name != package_name}
            for kind, names in names_by_kind.items()
        }


def ros_names(links: Iterable[str], joints: Iterable[str]) -> RosNames:
    """Returns names for ROS. Names that ROS accepts stay, and the others are changed so that they differ from
    these."""
    return RosNames(legal_names(links, "link"), legal_names(joints, "joint"))


def legal_names(names: Iterable[str], kind: str) -> dict[str, str]:
    """Returns a legal and unique name for each name; `kind` is put before a leading digit."""
    originals = list(names)
    legal = {name: name for name in originals if _legal_name(name, kind) == name}
    used_names = set(legal)
    for name in originals:
        if name not in legal:
            legal[name] = free_name(_legal_name(name, kind), used_names)
            used_names.add(legal[name])
    return {name: legal[name] for name in originals}


def _legal_name(name: str, kind: str) -> str:
    """Returns the name in [A-Za-z0-9_], without a leading digit. Different names may become equal."""
    plain_name = plain(name)
    return f"{kind}_{plain_name}" if plain_name[0].isdigit() else plain_name


def moveit_package_of(package: str) -> str:
    """Returns the name of MoveIt's package beside that of the description."""
    return f"{package.removesuffix('_description')}_moveit_config"


def macro_of(robot: str) -> str:
    """Returns the name of the xacro macro of a robot."""
    stem = stem_of(robot)
    return f"{stem}_robot" if stem in XACRO_TAGS else stem
