"""The elements of an SDF as numbers, words and poses."""

import numpy as np

from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array


class SdfError(ValueError):
    """The text is no SDF that is read here."""


def pose_of(node: Element | None) -> Array:
    """The (4, 4) pose of an element; the identity without one."""
    if node is None:
        return np.eye(4)
    if set(node.attrib) - {"relative_to"}:
        raise SdfError("of the attributes of a pose only relative_to is read")
    x, y, z, *rpy = numbers(node, 6)
    return from_parts(rotation_from_rpy((rpy[0], rpy[1], rpy[2])), np.array([x, y, z]))


def needed(above: Element, path: str) -> Element:
    """What an element must have. SdfError where it has none."""
    found = above.find(path)
    if found is None:
        raise SdfError(f"{above.tag} {above.get('name') or ''} has no <{path}>")
    return found


def numbers(node: Element, count: int) -> list[float]:
    """So many numbers. SdfError where the text is anything else."""
    try:
        found = [float(text) for text in (node.text or "").split()]
    except ValueError:
        found = []
    if len(found) != count or not np.isfinite(found).all():
        raise SdfError(f"<{node.tag}> is not {count} numbers: {node.text!r}")
    return found


def number(above: Element, path: str) -> float:
    """The number that an element must have."""
    return numbers(needed(above, path), 1)[0]


def bound(above: Element, path: str) -> float | None:
    """The number that an element may have."""
    return None if above.find(path) is None else number(above, path)


def truth(above: Element, path: str, unless: bool) -> bool:
    """Whether an element says yes; `unless`: what holds without it. SdfError for other words."""
    node = above.find(path)
    if node is None:
        return unless
    word = (node.text or "").strip().lower()
    if word not in ("true", "1", "false", "0"):
        raise SdfError(f"<{node.tag}> is neither true nor false: {node.text!r}")
    return word in ("true", "1")
