"""What the shapes of a USD look like, and how slippery they are, against the robot's."""

from collections.abc import Iterator
from pathlib import PurePosixPath

import numpy as np

from linkwright.stages.formats.usd.colours import ROUGHNESS, linear
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.validate.findings import differs
from linkwright.stages.validate.usd.shape_reader import ReadUsdShape

COLOUR = 1e-5
"""Colours are in single precision."""


def looks(element: str, which: str, shape: ReadUsdShape, wanted: Shape) -> Iterator[Finding]:
    """`element`: the body; `which`: the shape's role and number."""
    if wanted.colour is not None and wanted.role == "visual":
        yield from _colours(element, which, shape, wanted)
    friction = wanted.contact.friction if wanted.contact is not None else None
    expected = {}
    if friction is not None:
        slide, twist, roll = friction
        expected = dict.fromkeys(("physics:staticFriction", "physics:dynamicFriction"), slide)
        expected |= {"newton:torsionalFriction": twist, "newton:rollingFriction": roll}
    found = shape.look.friction
    for name in (*expected, *(found.keys() - expected.keys())):
        if not _alike(found.get(name), expected.get(name)):
            attribute = f"{which} material:binding:physics {name}"
            yield differs(element, attribute, found.get(name), expected.get(name))


def _colours(element: str, which: str, shape: ReadUsdShape, wanted: Shape) -> Iterator[Finding]:
    assert wanted.colour is not None
    rgb, look = linear(wanted.colour), shape.look
    expected = (*rgb, wanted.colour[3], ROUGHNESS)
    attribute = f"{which} material:binding"
    if not look.colour:
        yield differs(element, attribute, "no material of a surface", expected)
    elif PurePosixPath(look.image).name != (wanted.texture or ""):
        yield differs(element, attribute, look.image or "no image", wanted.texture or "no image")
    elif not np.allclose(look.colour, expected, atol=COLOUR):
        yield differs(element, attribute, look.colour, expected)
    if not look.display or not np.allclose(look.display, rgb, atol=COLOUR):
        yield differs(element, f"{which} primvars:displayColor", look.display or None, rgb)


def _alike(found: float | None, wanted: float | None) -> bool:
    if found is None or wanted is None:
        return found is wanted
    return abs(found - wanted) <= COLOUR * max(1.0, abs(wanted))
