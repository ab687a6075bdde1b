"""Names the materials of a robot: a colour, or an image times a colour."""

from collections.abc import Mapping

from linkwright.stages.robot.model.geometry import Colour, Geometry, Shape

Paint = tuple[Colour, str]
"""A colour, and the name of an image or ""."""

NAMED_COLOURS: Mapping[str, tuple[float, float, float]] = {
    "black": (0.0, 0.0, 0.0),
    "dark_grey": (0.25, 0.25, 0.25),
    "grey": (0.5, 0.5, 0.5),
    "light_grey": (0.75, 0.75, 0.75),
    "white": (1.0, 1.0, 1.0),
    "red": (0.85, 0.1, 0.1),
    "dark_red": (0.45, 0.05, 0.05),
    "orange": (1.0, 0.5, 0.1),
    "brown": (0.45, 0.27, 0.12),
    "gold": (0.8, 0.65, 0.3),
    "yellow": (1.0, 0.9, 0.1),
    "olive": (0.5, 0.5, 0.1),
    "green": (0.1, 0.65, 0.2),
    "dark_green": (0.05, 0.3, 0.1),
    "light_green": (0.6, 0.9, 0.6),
    "teal": (0.1, 0.55, 0.55),
    "cyan": (0.2, 0.85, 0.9),
    "light_blue": (0.55, 0.75, 0.95),
    "blue": (0.1, 0.3, 0.85),
    "navy": (0.08, 0.15, 0.4),
    "purple": (0.5, 0.15, 0.65),
    "magenta": (0.9, 0.15, 0.7),
    "pink": (1.0, 0.7, 0.75),
}
"""Name of a colour → its red, green and blue."""

MIN_OPAQUE_ALPHA = 0.99
"""Smallest opacity that counts as opaque."""


def paint(shape: Shape) -> Paint | None:
    """Returns the material of a shape; None for a shape without a colour."""
    return None if shape.colour is None else (shape.colour, shape.texture or "")


def materials(geometry: Geometry) -> dict[Paint, str]:
    """Returns the name of each material, materials without an image first. It is the word for the colour, or
    the name of the image; further materials with the same name get a number."""
    paints = {look for shape in geometry.shapes if (look := paint(shape)) is not None}
    untextured = sorted(look for look in paints if not look[1])
    textured = sorted((look for look in paints if look[1]), key=lambda look: (look[1], look[0]))
    names: dict[Paint, str] = {}
    taken: set[str] = set()
    for look in (*untextured, *textured):
        base_name = look[1].rpartition(".")[0] + "_material" if look[1] else word(look[0])
        name, count = base_name, 1
        while name in taken:
            count += 1
            name = f"{base_name}_{count}"
        names[look] = name
        taken.add(name)
    return names


def word(colour: Colour) -> str:
    """Returns the name of the nearest named colour, by a distance that approximates human vision."""
    *rgb, alpha = colour

    def distance(name: str) -> float:
        red, green, blue = (a - b for a, b in zip(rgb, NAMED_COLOURS[name], strict=True))
        # T. Riemersma, "Colour metric" (compuphase.com): the weights depend on the mean redness.
        mean = (rgb[0] + NAMED_COLOURS[name][0]) / 2
        return (2 + mean) * red**2 + 4 * green**2 + (3 - mean) * blue**2

    nearest = min(NAMED_COLOURS, key=distance)
    return nearest if alpha >= MIN_OPAQUE_ALPHA else f"clear_{nearest}"
