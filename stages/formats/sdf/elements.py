"""Reads the elements of an SDF as numbers, words and poses."""

import numpy as np

from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array


class SdfError(ValueError):
    """The error that a text is not an SDF of the kind that is read here."""


def pose_of(node: Element | None) -> Array:
    """Returns the pose (4, 4) in an element; the identity without an element. Raises SdfError for other
    attributes than `relative_to`, and for other texts than x, y, z, roll, pitch and yaw."""
    if node is None:
        return np.eye(4)
    if set(node.attrib) - {"relative_to"}:
        raise SdfError("relative_to is the only attribute of a pose that is read")
    x, y, z, *rpy = numbers(node, 6)
    return from_parts(rotation_from_rpy((rpy[0], rpy[1], rpy[2])), np.array([x, y, z]))


def required_element(above: Element, path: str) -> Element:
    """Returns an element that another element must have. Raises SdfError if it is missing."""
    element = above.find(path)
    if element is None:
        raise SdfError(f"{above.tag} {above.get('name') or ''} has no <{path}>")
    return element


def numbers(node: Element, count: int) -> list[float]:
    """Returns the `count` finite numbers of an element. Raises SdfError for any other text."""
    try:
        values = [float(text) for text in (node.text or "").split()]
    except ValueError:
        values = []
    if len(values) != count or not np.isfinite(values).all():
        raise SdfError(f"<{node.tag}> is not {count} numbers: {node.text!r}")
    return values


def number(above: Element, path: str) -> float:
    """Returns the number in an element that must be there. Raises SdfError without it."""
    return numbers(required_element(above, path), 1)[0]


def bound(above: Element, path: str) -> float | None:
    """Returns the number in an element that may be missing; None without it. Raises SdfError if it is not a
    number."""
    return None if above.find(path) is None else number(above, path)


def truth(above: Element, path: str, unless: bool) -> bool:
    """Returns the truth value in an element; `unless`: the value without the element. Raises SdfError for
    words other than true, 1, false and 0."""
    node = above.find(path)
    if node is None:
        return unless
    word = (node.text or "").strip().lower()
    if word not in ("true", "1", "false", "0"):
        raise SdfError(f"<{node.tag}> is neither true nor false: {node.text!r}")
    return word in ("true", "1")
