"""Makes the findings of checks, which name an element, an attribute, and the actual and expected value."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.robot import Array

MAX_FINDINGS = 5
"""Largest number of findings of a check: more would not help."""

ROUNDING = 1e-12
"""Share of an array's largest entry up to which entries are shown as 0."""


def named(tag: str, name: str) -> str:
    """Returns the title of an element in findings: its tag, and its name in quotes."""
    return f'{tag} "{name}"'


def link(name: str, urdf: bool) -> str:
    """Returns the title of a link in findings: a link in a URDF, a body in an MJCF."""
    return named("link" if urdf else "body", name)


def named_joint(model: Any, index: int) -> str:
    """Returns the title of a joint of a compiled model. A joint without a name is called by the body that it
    moves."""
    name = model.joint(index).name
    return named("joint", name) if name else f"joint of {link(_mover(model, index), urdf=False)}"


def _mover(model: Any, index: int) -> str:
    return str(model.body(int(model.jnt_bodyid[index])).name)


def unstable(joint: str, words: str) -> Finding:
    """Returns the finding of a failed run, at the joint that failed first ("" if unknown)."""
    element, attribute = (named("joint", joint), "armature") if joint else ("option", "timestep")
    return Finding(element, attribute, words)


def differs(element: str, attribute: str, actual: object, expected: object, unit: str = "") -> Finding:
    """Returns a finding on an attribute that differs. The values are numbers, arrays of numbers, or text."""
    ending = f" [{unit}]" if unit else ""
    return Finding(element, attribute, f"is {shown(actual)}, expected {shown(expected)}{ending}")


def shown(value: object) -> str:
    """Returns a value as text for a message, numbers with eight digits."""
    if value is None:
        return "none"
    if isinstance(value, str | bool | int):
        return str(value)
    numbers = np.ravel(np.asarray(value, dtype=float))
    least = (
        ROUNDING * float(np.abs(numbers[np.isfinite(numbers)]).max(initial=0.0)) if len(numbers) > 1 else 0.0
    )
    return " ".join(f"{0.0 if abs(number) <= least else float(number):.8g}" for number in numbers)


def largest_error(errors: Iterable[float]) -> float:
    """Returns the largest of the errors; 0 without errors. NaN counts as infinite, so that it passes no
    check: Python's `max` skips a NaN that is not the first value."""
    return max((math.inf if math.isnan(error) else error for error in errors), default=0.0)


def worst_first(findings: Iterable[tuple[float, Finding]]) -> tuple[Finding, ...]:
    """Returns the findings with the largest values; NaN counts as the largest."""
    order = sorted(findings, key=lambda row: -np.inf if np.isnan(row[0]) else -row[0])
    return tuple(finding for _, finding in order[:MAX_FINDINGS])


def few(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Returns the first `MAX_FINDINGS` findings."""
    return tuple(findings)[:MAX_FINDINGS]


def pose_findings(
    element: str, actual: Array, expected: Array, attributes: Sequence[str], least: float
) -> tuple[Finding, ...]:
    """Returns the findings on two poses (4, 4) whose position or orientation differs by more than `least`
    [m, rad]. `attributes`: the names of position and orientation."""
    position, turn = attributes
    offset, angle = offset_and_angle(actual, expected)
    findings = []
    if not offset <= least:
        findings.append(differs(element, position, actual[:3, 3], expected[:3, 3], "m"))
    if not angle <= least:
        findings.append(
            Finding(
                element,
                turn,
                f"is turned by {shown(np.degrees(angle))} degrees from the expected orientation",
            )
        )
    return tuple(findings)


def offset_and_angle(actual: Array, expected: Array) -> tuple[float, float]:
    """Returns the distance [m] and the angle [rad] between two poses (4, 4)."""
    relative = expected[:3, :3].T @ actual[:3, :3]
    doubled = relative - relative.T
    sine = float(np.linalg.norm([doubled[2, 1], doubled[0, 2], doubled[1, 0]])) / 2
    return (
        float(np.linalg.norm(actual[:3, 3] - expected[:3, 3])),
        float(np.arctan2(sine, (np.trace(relative) - 1) / 2)),
    )
