"""Names the figures of a build for people."""

from typing import NamedTuple


class FigureName(NamedTuple):
    """A figure's name for one thing and for several, and its unit ("" for a number of things)."""

    singular: str
    plural: str
    unit: str = ""


NAMES = {
    "links": FigureName("link", "links"),
    "joints": FigureName("joint", "joints"),
    "dof": FigureName("degree of freedom", "degrees of freedom"),
    "dofs": FigureName("degree of freedom of joints", "degrees of freedom of joints"),
    "coordinates": FigureName("coordinate", "coordinates"),
    "gruebler": FigureName("degree of freedom by Grübler", "degrees of freedom by Grübler"),
    "meshes": FigureName("mesh", "meshes"),
    "loops": FigureName("loop", "loops"),
    "mass": FigureName("mass", "mass", "kg"),
    "parts": FigureName("part", "parts"),
    "triangles": FigureName("triangle", "triangles"),
    "steps_per_second": FigureName("step per second", "steps per second"),
    "checks_failed": FigureName("check failed", "checks failed"),
    "checks_warned": FigureName("check with a warning", "checks with a warning"),
}
"""Figures by their key in a report; the name of any other figure is its key."""


def name_of(key: str) -> str:
    """Returns the name of a figure on an axis or above a column: "mass, kg"."""
    figure = NAMES.get(key)
    if figure is None:
        return key.replace("_", " ")
    return f"{figure.plural}, {figure.unit}" if figure.unit else figure.plural


def sentence_name(key: str) -> str:
    """Returns the name of a figure in a sentence."""
    figure = NAMES.get(key)
    return key.replace("_", " ") if figure is None else figure.plural


def figure_text(key: str, value: float) -> str:
    """Returns a figure with its value: "11 links", "mass 3.2 kg"."""
    figure = NAMES.get(key)
    if figure is None:
        return f"{key.replace('_', ' ')} {value_text(value)}"
    if figure.unit:
        return f"{figure.plural} {value_text(value)} {figure.unit}"
    return f"{value_text(value)} {figure.singular if value == 1 else figure.plural}"


def value_text(value: float) -> str:
    """Returns a figure's value as text."""
    return f"{value:,}" if isinstance(value, int) else f"{value:.6g}"
