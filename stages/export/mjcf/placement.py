"""Poses as MJCF attributes, and elements that have one."""

from linkwright.stages.formats.numbers import LENGTH, spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.mjcf_extras import MjcfElement
from linkwright.stages.robot.model.poses import quat_from_rotation
from linkwright.stages.robot.model.robot import Array


def placement(pose: Array) -> dict[str, str]:
    """`pos` and `quat` of a (4, 4) pose; identity is left out."""
    out = {}
    position = spaced(pose[:3, 3], least=LENGTH)
    if position != "0 0 0":
        out["pos"] = position
    return out | orientation(pose[:3, :3])


def orientation(rotation: Array) -> dict[str, str]:
    """`quat` of a (3, 3) rotation; identity is left out."""
    quat = spaced(quat_from_rotation(rotation))
    return {} if quat == "1 0 0 0" else {"quat": quat}


def write_element(above: Element, own: MjcfElement) -> Element:
    """An element of an MJCF source with all that is in it, under another."""
    names = {attribute: name for attribute, _, name in own.names}
    attributes = dict(own.attributes)
    title = {"name": attributes.pop("name")} if "name" in attributes else {}
    made = element(above, own.tag, **title, **names, **attributes)
    for child in own.children:
        write_element(made, child)
    return made


def write_placed(above: Element, own: MjcfElement, pose: Array) -> Element:
    """An element of an MJCF source at a pose (4, 4) of what it is under; a light shines along its z axis."""
    made = write_element(above, own)
    place = placement(pose)
    if own.tag == "light":
        place = {"pos": place.get("pos", "0 0 0"), "dir": spaced(pose[:3, 2], least=1.0)}
    for name, text in place.items():
        made.set(name, text)
    return made


def above_bodies(body: Element, made: Element) -> None:
    """Moves what was made last to before the bodies below, so that a body's own things stay together."""
    first = body.find("body")
    if first is not None:
        first.addprevious(made)
