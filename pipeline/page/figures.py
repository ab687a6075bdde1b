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
"""Figures by their key in a report; of others the key is the name."""


def name_of(key: str) -> str:
    """The name of a figure on an axis or above a column: "mass, kg"."""
    found = NAMES.get(key)
    if found is None:
        return key.replace("_", " ")
    return f"{found.several}, {found.unit}" if found.unit else found.several


def said(key: str) -> str:
    """The name of a figure in a sentence."""
    found = NAMES.get(key)
    return key.replace("_", " ") if found is None else found.several


def counted(key: str, value: float) -> str:
    """A figure with its value: "11 links", "mass 3.2 kg"."""
    found = NAMES.get(key)
    if found is None:
        return f"{key.replace('_', ' ')} {shown(value)}"
    if found.unit:
        return f"{found.several} {shown(value)} {found.unit}"
    return f"{shown(value)} {found.one if value == 1 else found.several}"


def shown(value: float) -> str:
    """A figure as people read it."""
    return f"{value:,}" if isinstance(value, int) else f"{value:.6g}"
