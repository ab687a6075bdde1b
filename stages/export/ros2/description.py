"""Makes the URDF of a ROS 2 package: the robot's URDF, with paths and names for ROS."""

import re
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass

from linkwright.stages.export.ros2.names import RosNames, ros_names
from linkwright.stages.formats.xml import Element, parse, tag

_ASSET_PATH = re.compile("(?:package://[^/]+/)?assets/([^/]+)$")
"""Matches the path of a mesh or texture in either form of the robot's own URDF, relative or by package. The
group is the name of the file."""

MOVING_TYPES = ("revolute", "continuous", "prismatic")
"""Types of joints that have a single value."""


@dataclass(frozen=True, slots=True, eq=False)
class Description:
    """The URDF of a package."""

    root: Element
    """The root element of the URDF."""

    names: RosNames
    """The names in the package, by those in the robot's own URDF."""

    @property
    def base(self) -> str:
        """Returns the root link: the first link that is not the child of a joint."""
        children = {
            node.get("link") for joint in self.root.iterchildren("joint") for node in joint.iter("child")
        }
        links = [str(node.get("name")) for node in self.root.iterchildren("link")]
        return next((name for name in links if name not in children), links[0])

    @property
    def moving(self) -> list[Element]:
        """Returns the joints that have a value, in the order of the file."""
        return [joint for joint in self.root.iterchildren("joint") if joint.get("type") in MOVING_TYPES]


def description_of(urdf: bytes, package: str) -> Description:
    """Returns the description of a package, from a robot's URDF."""
    root = parse(urdf, large=True)
    for mujoco_settings in root.findall("mujoco"):
        root.remove(mujoco_settings)
    names = ros_names(
        (str(child.get("name")) for child in root.iterchildren("link")),
        (str(child.get("name")) for child in root.iterchildren("joint")),
    )
    for node in root.iter("mesh", "texture"):
        path = _ASSET_PATH.match(node.get("filename", ""))
        if path is not None:
            node.set("filename", f"package://{package}/meshes/{path.group(1)}")
    names_by_kind = {"link": names.links, "joint": names.joints}
    for node, key, kind in list(references(root)):
        if kind in names_by_kind:
            node.set(key, names_by_kind[kind].get(node.get(key), node.get(key)))
    return Description(root, names)


def references(root: Element) -> Iterator[tuple[Element, str, str]]:
    """Yields (element, attribute, kind) of each name of a link, joint, material or transmission in a URDF,
    both where it is defined and where it is referred to."""
    for node in root.iterchildren():
        kind = tag(node)
        if kind in ("link", "joint", "material", "transmission"):
            yield node, "name", kind
        elif kind == "gazebo" and node.get("reference"):
            # Its attribute names a link or a joint; a link comes first if both have the name.
            reference = node.get("reference")
            is_joint = not _has_element(root, "link", reference) and _has_element(root, "joint", reference)
            yield node, "reference", "joint" if is_joint else "link"
        if kind == "link":
            yield from ((child, "name", "material") for child in node.iter("material") if child.get("name"))
        elif kind == "joint":
            yield from ((child, "link", "link") for child in node.iterchildren("parent", "child"))
            yield from ((child, "joint", "joint") for child in node.iterchildren("mimic"))
        elif kind == "transmission":
            yield from ((child, "name", "joint") for child in node.iterchildren("joint"))
            yield from ((child, "name", "transmission") for child in node.iterchildren("actuator"))
        elif kind == "ros2_control":
            yield from ((child, "name", "joint") for child in node.iter("joint"))


def _has_element(root: Element, kind: str, name: str) -> bool:
    """Tells whether a URDF has a link or joint (`kind`) of this name."""
    return any(child.get("name") == name for child in root.iterchildren(kind))


def without_control(root: Element) -> tuple[Element, list[Element]]:
    """Returns a copy of a URDF without its <ros2_control> elements, and these elements."""
    copy = deepcopy(root)
    controls = copy.findall("ros2_control")
    for control in controls:
        copy.remove(control)
    return copy, controls
