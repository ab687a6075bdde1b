"""What a check says of what it does not accept: element of the file, attribute, found and expected."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.robot import Array

MOST = 5
"""Findings of one check: the rest would say no more."""

ROUNDING = 1e-12
"""An entry of an array is shown as 0 where it is no larger than this share of the largest."""


def named(tag: str, name: str) -> str:
    """An element of a file, by tag and name."""
    return f'{tag} "{name}"'


def link(name: str, urdf: bool) -> str:
    """A link, as its file calls it."""
    return named("link" if urdf else "body", name)


def named_joint(model: Any, index: int) -> str:
    """A joint of a compiled model; one without a name by the body that it moves."""
    name = model.joint(index).name
    return named("joint", name) if name else f"joint of {link(_mover(model, index), urdf=False)}"


def _mover(model: Any, index: int) -> str:
    return str(model.body(int(model.jnt_bodyid[index])).name)


def unstable(joint: str, words: str) -> Finding:
    """Of a run that failed: the joint that it began with, "" for none, and what it may lack."""
    element, attribute = (named("joint", joint), "armature") if joint else ("option", "timestep")
    return Finding(element, attribute, words)


def differs(element: str, attribute: str, found: object, expected: object, unit: str = "") -> Finding:
    """Found and expected: numbers, arrays of them, or text."""
    ending = f" [{unit}]" if unit else ""
    return Finding(element, attribute, f"is {shown(found)}, expected {shown(expected)}{ending}")


def shown(value: object) -> str:
    """A value in a message: numbers by eight digits."""
    if value is None:
        return "none"
    if isinstance(value, str | bool | int):
        return str(value)
    numbers = np.ravel(np.asarray(value, dtype=float))
    least = (
        ROUNDING * float(np.abs(numbers[np.isfinite(numbers)]).max(initial=0.0)) if len(numbers) > 1 else 0.0
    )
    return " ".join(f"{0.0 if abs(one) <= least else float(one):.8g}" for one in numbers)


def worst_first(found: Iterable[tuple[float, Finding]]) -> tuple[Finding, ...]:
    """The findings with the largest values; what is not a number is the largest."""
    order = sorted(found, key=lambda one: -np.inf if np.isnan(one[0]) else -one[0])
    return tuple(finding for _, finding in order[:MOST])


def few(found: Iterable[Finding]) -> tuple[Finding, ...]:
    """The first of them."""
    return tuple(found)[:MOST]


def place_differs(
    element: str, found: Array, expected: Array, attributes: Sequence[str], least: float
) -> tuple[Finding, ...]:
    """Of two poses (4, 4) what differs by more than `least` [m, rad]: the position and the turn, by the names
    of their attributes."""
    position, turn = attributes
    offset, angle = apart(found, expected)
    both = []
    if not offset <= least:
        both.append(differs(element, position, found[:3, 3], expected[:3, 3], "m"))
    if not angle <= least:
        both.append(
            Finding(element, turn, f"is turned by {shown(np.degrees(angle))} degrees from the expected")
        )
    return tuple(both)


def apart(found: Array, expected: Array) -> tuple[float, float]:
    """The offset [m] and the turn [rad] between two poses (4, 4)."""
    relative = expected[:3, :3].T @ found[:3, :3]
    doubled = relative - relative.T
    sine = float(np.linalg.norm([doubled[2, 1], doubled[0, 2], doubled[1, 0]])) / 2
    return (
        float(np.linalg.norm(found[:3, 3] - expected[:3, 3])),
        float(np.arctan2(sine, (np.trace(relative) - 1) / 2)),
    )
