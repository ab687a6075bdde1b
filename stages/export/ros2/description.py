"""The URDF of a ROS 2 package: the robot's own, with paths and names for ROS."""

import re
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass

from linkwright.stages.export.ros2.names import RosNames, ros_names
from linkwright.stages.formats.xml import Element, parse, tag

_OURS = re.compile("(?:package://[^/]+/)?assets/([^/]+)$")
"""A path of ours, in either of the ways in which a URDF can have it."""

MOVING = ("revolute", "continuous", "prismatic")
"""The types of joints that have one value."""


@dataclass(frozen=True, slots=True, eq=False)
class Description:
    """`root`: the URDF in the package; `names` there by those in the URDF beside it."""

    root: Element
    names: RosNames

    @property
    def base(self) -> str:
        """The link that no joint holds: the first where there are several."""
        held = {one.get("link") for joint in self.root.iterchildren("joint") for one in joint.iter("child")}
        links = [str(one.get("name")) for one in self.root.iterchildren("link")]
        return next((name for name in links if name not in held), links[0])

    @property
    def moving(self) -> list[Element]:
        """The joints that have a value, in the order of the file."""
        return [one for one in self.root.iterchildren("joint") if one.get("type") in MOVING]


def described(urdf: bytes, package: str) -> Description:
    """The description of a package from a robot's URDF."""
    root = parse(urdf, large=True)
    for own in root.findall("mujoco"):
        root.remove(own)
    names = ros_names(
        (str(one.get("name")) for one in root.iterchildren("link")),
        (str(one.get("name")) for one in root.iterchildren("joint")),
    )
    for node in root.iter("mesh", "texture"):
        path = _OURS.match(node.get("filename", ""))
        if path is not None:
            node.set("filename", f"package://{package}/meshes/{path.group(1)}")
    every = {"link": names.links, "joint": names.joints}
    for node, key, kind in list(references(root)):
        if kind in every:
            node.set(key, every[kind].get(node.get(key), node.get(key)))
    return Description(root, names)


def references(root: Element) -> Iterator[tuple[Element, str, str]]:
    """(element, attribute, kind) of each name of a link, joint, material or transmission in a URDF: where it
    is given, and where it is referred to."""
    for node in root.iterchildren():
        kind = tag(node)
        if kind in ("link", "joint", "material", "transmission"):
            yield node, "name", kind
        elif kind == "gazebo" and node.get("reference"):
            named = {"link": "link", "joint": "joint"}
            found = next((one for one in named if _has(root, one, node.get("reference"))), "link")
            yield node, "reference", found
        if kind == "link":
            yield from ((one, "name", "material") for one in node.iter("material") if one.get("name"))
        elif kind == "joint":
            yield from ((one, "link", "link") for one in node.iterchildren("parent", "child"))
            yield from ((one, "joint", "joint") for one in node.iterchildren("mimic"))
        elif kind == "transmission":
            yield from ((one, "name", "joint") for one in node.iterchildren("joint"))
            yield from ((one, "name", "transmission") for one in node.iterchildren("actuator"))
        elif kind == "ros2_control":
            yield from ((one, "name", "joint") for one in node.iter("joint"))


def _has(root: Element, kind: str, name: str) -> bool:
    return any(one.get("name") == name for one in root.iterchildren(kind))


def without_control(root: Element) -> tuple[Element, list[Element]]:
    """A copy of a URDF without its <ros2_control>s, and these."""
    rest = deepcopy(root)
    found = rest.findall("ros2_control")
    for one in found:
        rest.remove(one)
    return rest, found
