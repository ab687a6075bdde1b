"""Writes poses as MJCF attributes, and elements at a pose."""

from linkwright.stages.formats.numbers import LENGTH, spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.mjcf_extras import MjcfElement
from linkwright.stages.robot.model.poses import quat_from_rotation
from linkwright.stages.robot.model.robot import Array


def placement(pose: Array) -> dict[str, str]:
    """Returns `pos` and `quat` of a pose (4, 4); identity is left out."""
    attributes = {}
    position = spaced(pose[:3, 3], least=LENGTH)
    if position != "0 0 0":
        attributes["pos"] = position
    return attributes | orientation(pose[:3, :3])


def orientation(rotation: Array) -> dict[str, str]:
    """Returns `quat` of a rotation (3, 3); identity is left out."""
    quat = spaced(quat_from_rotation(rotation))
    return {} if quat == "1 0 0 0" else {"quat": quat}


def write_element(parent: Element, source: MjcfElement) -> Element:
    """Writes an element of an MJCF source with its children, under another element, and returns it."""
    names = {attribute: name for attribute, _, name in source.names}
    attributes = dict(source.attributes)
    # The name is the first attribute of every element in our files.
    own_name = {"name": attributes.pop("name")} if "name" in attributes else {}
    node = element(parent, source.tag, **own_name, **names, **attributes)
    for child in source.children:
        write_element(node, child)
    return node


def write_at_pose(parent: Element, source: MjcfElement, pose: Array) -> Element:
    """Writes an element of an MJCF source at a pose (4, 4) in the frame of its parent, and returns it. A
    light shines along the z axis of its pose."""
    node = write_element(parent, source)
    pose_attributes = placement(pose)
    if source.tag == "light":
        pose_attributes = {"pos": pose_attributes.get("pos", "0 0 0"), "dir": spaced(pose[:3, 2], least=1.0)}
    for name, text in pose_attributes.items():
        node.set(name, text)
    return node


def move_before_bodies(body: Element, node: Element) -> None:
    """Moves a new child of a body before the child bodies, so that the elements of the body itself stay
    together."""
    first = body.find("body")
    if first is not None:
        first.addprevious(node)
