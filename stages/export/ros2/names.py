"""Names that ROS takes: of packages, links, joints and sensors.

Frames of TF and joints are named in topics and parameters, where a point, a slash or a space has a meaning of
its own, and a name that begins with a digit is a number.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from linkwright.stages.export.package_names import stem_of
from linkwright.stages.robot.text.names import free, plain

TAGS = frozenset(
    {"arg", "attribute", "call", "element", "if", "include", "insert_block", "macro", "property", "unless"}
)
"""Elements of xacro: no macro can have these names."""


@dataclass(frozen=True, slots=True)
class RosNames:
    """Names in the package by those in the URDF beside it."""

    links: Mapping[str, str]
    joints: Mapping[str, str]

    @property
    def renamed(self) -> dict[str, dict[str, str]]:
        """What has another name in the package, by kind."""
        every = {"links": self.links, "joints": self.joints}
        return {
            kind: {name: own for name, own in names.items() if name != own} for kind, names in every.items()
        }


def ros_names(links: Iterable[str], joints: Iterable[str]) -> RosNames:
    """Names stay where ROS takes them; the others give way to these."""
    return RosNames(legal_names(links, "link"), legal_names(joints, "joint"))


def legal_names(names: Iterable[str], kind: str) -> dict[str, str]:
    """A legal name for each; `kind` stands before one that begins with a digit."""
    every = list(names)
    found = {name: name for name in every if _legal(name, kind) == name}
    taken = set(found)
    for name in every:
        if name not in found:
            found[name] = free(_legal(name, kind), taken)
            taken.add(found[name])
    return {name: found[name] for name in every}


def _legal(name: str, kind: str) -> str:
    name = plain(name)
    return f"{kind}_{name}" if name[0].isdigit() else name


def moveit_package_of(package: str) -> str:
    """The name of MoveIt's package beside that of the description."""
    return f"{package.removesuffix('_description')}_moveit_config"


def macro_of(robot: str) -> str:
    """The name of the xacro macro of a robot."""
    stem = stem_of(robot)
    return f"{stem}_robot" if stem in TAGS else stem
