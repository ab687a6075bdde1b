"""The materials of a robot: a colour, or an image times a colour."""

from collections.abc import Mapping

from linkwright.stages.robot.model.geometry import Colour, Geometry, Shape

Paint = tuple[Colour, str]
"""A colour and the name of an image, "" for none."""

WORDS: Mapping[str, tuple[float, float, float]] = {
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
"""Names of colours, and what they mean here."""

CLEAR = 0.99
"""The least opacity that counts as opaque."""


def paint(shape: Shape) -> Paint | None:
    """What a shape looks like; None for no material."""
    return None if shape.colour is None else (shape.colour, shape.texture or "")


def materials(geometry: Geometry) -> dict[Paint, str]:
    """The name of each material, those without an image first: the word for its colour, or the name of its
    image, with a number from the second that has it on."""
    found = {one for shape in geometry.shapes if (one := paint(shape)) is not None}
    plain = sorted(one for one in found if not one[1])
    textured = sorted((one for one in found if one[1]), key=lambda one: (one[1], one[0]))
    names: dict[Paint, str] = {}
    taken: set[str] = set()
    for one in (*plain, *textured):
        wanted = one[1].rpartition(".")[0] + "_material" if one[1] else word(one[0])
        name, number = wanted, 1
        while name in taken:
            number += 1
            name = f"{wanted}_{number}"
        names[one] = name
        taken.add(name)
    return names


def word(colour: Colour) -> str:
    """The name of the nearest colour that has one, by the eye's weights of red, green and blue."""
    *rgb, alpha = colour

    def off(name: str) -> float:
        red, green, blue = (a - b for a, b in zip(rgb, WORDS[name], strict=True))
        # A cheap distance as the eye sees it: T. Riemersma, "Colour metric" (compuphase.com), mean redness.
        mean = (rgb[0] + WORDS[name][0]) / 2
        return (2 + mean) * red**2 + 4 * green**2 + (3 - mean) * blue**2

    nearest = min(WORDS, key=off)
    return nearest if alpha >= CLEAR else f"clear_{nearest}"
