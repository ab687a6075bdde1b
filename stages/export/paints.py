"""The materials of a robot: a colour, or an image times a colour."""

from stages.robot.geometry import Colour, Geometry, Shape

Paint = tuple[Colour, str]
"""A colour and the name of an image, "" for none."""


def paint(shape: Shape) -> Paint | None:
    """What a shape looks like; None for no material."""
    return None if shape.colour is None else (shape.colour, shape.texture or "")


def materials(geometry: Geometry) -> dict[Paint, str]:
    """The name of each material, those without an image first."""
    found = {one for shape in geometry.shapes if (one := paint(shape)) is not None}
    plain = sorted(one for one in found if not one[1])
    textured = sorted((one for one in found if one[1]), key=lambda one: (one[1], one[0]))
    names = {one: f"colour_{count}" for count, one in enumerate(plain)}
    return names | {one: f"textured_{count}" for count, one in enumerate(textured)}
