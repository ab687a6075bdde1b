"""Compares the materials (colour, opacity, image, friction) of a USD's shapes with those of the robot's
shapes."""

from collections.abc import Iterator
from pathlib import PurePosixPath

import numpy as np

from linkwright.stages.formats.usd.colours import ROUGHNESS, to_linear_rgb
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.validate.findings import differs
from linkwright.stages.validate.usd.shape_reader import ReadUsdShape

FLOAT32_TOLERANCE = 1e-5
"""Tolerance of colours and friction coefficients, which a USD has in single precision; relative for
coefficients above 1."""


def look_differences(
    element: str, shape_title: str, shape: ReadUsdShape, expected_shape: Shape
) -> Iterator[Finding]:
    """Yields the differences of a shape's material. `element`: the title of the body in findings;
    `shape_title`: the shape's role and number, such as "visual 2"."""
    if expected_shape.colour is not None and expected_shape.role == "visual":
        yield from _surface_differences(element, shape_title, shape, expected_shape)
    yield from _friction_differences(element, shape_title, shape, expected_shape)


def _friction_differences(
    element: str, shape_title: str, shape: ReadUsdShape, expected_shape: Shape
) -> Iterator[Finding]:
    """Yields the differences of the coefficients of friction of a shape."""
    friction = expected_shape.contact.friction if expected_shape.contact is not None else None
    expected = {}
    if friction is not None:
        # MuJoCo and the robot have one coefficient of sliding; UsdPhysics has a static and a dynamic
        # coefficient.
        slide, twist, roll = friction
        expected = dict.fromkeys(("physics:staticFriction", "physics:dynamicFriction"), slide)
        expected |= {"newton:torsionalFriction": twist, "newton:rollingFriction": roll}
    actual = shape.look.friction
    for name in (*expected, *(actual.keys() - expected.keys())):
        if not _is_same(actual.get(name), expected.get(name)):
            attribute = f"{shape_title} material:binding:physics {name}"
            yield differs(element, attribute, actual.get(name), expected.get(name))


def _surface_differences(
    element: str, shape_title: str, shape: ReadUsdShape, expected_shape: Shape
) -> Iterator[Finding]:
    """Yields the differences of the colour, the opacity and the image of a visual shape."""
    assert expected_shape.colour is not None
    linear_rgb, look = to_linear_rgb(expected_shape.colour), shape.look
    # As in the colour of a look: linear RGB, opacity, roughness.
    expected = (*linear_rgb, expected_shape.colour[3], ROUGHNESS)
    attribute = f"{shape_title} material:binding"
    # Only the first difference of a surface material is reported.
    if not look.colour:
        yield differs(element, attribute, "no surface material", expected)
    elif PurePosixPath(look.image).name != (expected_shape.texture or ""):
        yield differs(element, attribute, look.image or "no image", expected_shape.texture or "no image")
    elif not np.allclose(look.colour, expected, atol=FLOAT32_TOLERANCE):
        yield differs(element, attribute, look.colour, expected)
    if not look.display_colour or not np.allclose(look.display_colour, linear_rgb, atol=FLOAT32_TOLERANCE):
        yield differs(
            element, f"{shape_title} primvars:displayColor", look.display_colour or None, linear_rgb
        )


def _is_same(actual: float | None, expected: float | None) -> bool:
    """Tells whether two coefficients are equal, or both missing."""
    if actual is None or expected is None:
        return actual is expected
    return abs(actual - expected) <= FLOAT32_TOLERANCE * max(1.0, abs(expected))
