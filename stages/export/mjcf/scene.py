"""scene.xml: the robot in a small world, with a floor, light and sky, ready for a viewer."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stages.export.mjcf.placement import placement
from stages.formats.numbers import spaced
from stages.formats.xml import Element, parse, to_bytes
from stages.robot.poses import from_parts, rotation_from_rpy

if TYPE_CHECKING:
    from stages.export.keys import GroundKeys

TEMPLATE = Path(__file__).with_name("scene.xml")

FLOOR = ("asset/texture[@name='checker']", "asset/material[@name='checker']", "worldbody/geom[@name='floor']")
"""The elements of the template that make the floor."""


def write_scene(robot: str, ground: "GroundKeys") -> bytes:
    """The scene around `<robot>.xml`, which it includes."""
    root = parse(TEMPLATE.read_bytes())
    root.set("model", f"{robot}_scene")
    root.find("include").set("file", f"{robot}.xml")
    parts = [root.find(path) for path in FLOOR]
    if ground.kind == "none":
        for part in parts:
            part.getparent().remove(part)
    else:
        _set_floor(parts[-1], ground)
    return to_bytes(root)


def _set_floor(floor: Element, ground: "GroundKeys") -> None:
    pose = from_parts(rotation_from_rpy(ground.rpy), np.array(ground.xyz))
    floor.set("size", f"{spaced(np.array(ground.size) / 2)} 0.05")
    floor.set("friction", spaced(ground.friction))
    for name, value in placement(pose).items():
        floor.set(name, value)
