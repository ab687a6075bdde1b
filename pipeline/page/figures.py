"""What the figures of a build are called for people."""

from typing import NamedTuple


class FigureName(NamedTuple):
    """One and several of a figure, in words; `unit`: "" for a number of things."""

    one: str
    several: str
    unit: str = ""


NAMES = {
    "links": FigureName("link", "links"),
    "joints": FigureName("joint", "joints"),
    "dof": FigureName("degree of freedom", "degrees of freedom"),
    "loops": FigureName("loop", "loops"),
    "mass": FigureName("mass", "mass", "kg"),
    "parts": FigureName("part", "parts"),
    "triangles": FigureName("triangle", "triangles"),
    "steps_per_second": FigureName("steps per second", "steps per second"),
}
"""Figures by their key in a report; of others the key is the name."""


def name_of(key: str) -> str:
    """The name of a figure on an axis or above a column: "mass, kg"."""
    found = NAMES.get(key)
    if found is None:
        return key.replace("_", " ")
    return f"{found.several}, {found.unit}" if found.unit else found.several


def shown(value: float) -> str:
    """A figure as people read it."""
    return f"{value:,}" if isinstance(value, int) else f"{value:.6g}"
