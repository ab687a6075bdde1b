"""Compares the looks and the friction of a USD's shapes with the robot's."""

from collections.abc import Iterator
from pathlib import PurePosixPath

import numpy as np

from linkwright.stages.formats.usd.colours import ROUGHNESS, linear
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.validate.findings import differs
from linkwright.stages.validate.usd.shape_reader import ReadUsdShape

COLOUR_TOLERANCE = 1e-5
"""Tolerance of colours, which are in single precision."""


def looks(element: str, which: str, shape: ReadUsdShape, in_robot: Shape) -> Iterator[Finding]:
    """Compares the look of a shape. `element`: the title of the body; `which`: the shape's role and
    number."""
    if in_robot.colour is not None and in_robot.role == "visual":
        yield from _colours(element, which, shape, in_robot)
    friction = in_robot.contact.friction if in_robot.contact is not None else None
    expected = {}
    if friction is not None:
        slide, twist, roll = friction
        expected = dict.fromkeys(("physics:staticFriction", "physics:dynamicFriction"), slide)
        expected |= {"newton:torsionalFriction": twist, "newton:rollingFriction": roll}
    friction_found = shape.look.friction
    for name in (*expected, *(friction_found.keys() - expected.keys())):
        if not _is_same(friction_found.get(name), expected.get(name)):
            attribute = f"{which} material:binding:physics {name}"
            yield differs(element, attribute, friction_found.get(name), expected.get(name))


def _colours(element: str, which: str, shape: ReadUsdShape, in_robot: Shape) -> Iterator[Finding]:
    assert in_robot.colour is not None
    rgb, look = linear(in_robot.colour), shape.look
    expected = (*rgb, in_robot.colour[3], ROUGHNESS)
    attribute = f"{which} material:binding"
    if not look.colour:
        yield differs(element, attribute, "no material of a surface", expected)
    elif PurePosixPath(look.image).name != (in_robot.texture or ""):
        yield differs(element, attribute, look.image or "no image", in_robot.texture or "no image")
    elif not np.allclose(look.colour, expected, atol=COLOUR_TOLERANCE):
        yield differs(element, attribute, look.colour, expected)
    if not look.display or not np.allclose(look.display, rgb, atol=COLOUR_TOLERANCE):
        yield differs(element, f"{which} primvars:displayColor", look.display or None, rgb)


def _is_same(actual: float | None, expected: float | None) -> bool:
    if actual is None or expected is None:
        return actual is expected
    return abs(actual - expected) <= COLOUR_TOLERANCE * max(1.0, abs(expected))
