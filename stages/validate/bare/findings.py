"""What the checks of a bare file give: findings, each with the code of its check."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from linkwright.stages.robot.check import CheckLevel, Finding
from linkwright.stages.validate.reading.documents import ModelDocument


@dataclass(frozen=True, slots=True)
class BareCheck:
    """A check of a bare file: its `name` and `level`, and what it says where it passes."""

    name: str
    level: CheckLevel
    passed: str


CHECKS = {
    "C-TREE": BareCheck("tree", "error", "the links are one tree, from one root"),
    "C-MIMIC": BareCheck("mimics", "error", "no joint follows itself"),
    "C-DIRECTION": BareCheck("directions", "error", "every axis and quaternion has a direction"),
    "C-LIMIT": BareCheck("limits", "error", "every range rises, and nothing resists with a negative number"),
    "C-SOLID": BareCheck("inertials", "error", "every mass is positive, every inertia that of a solid"),
    "C-UNITS": BareCheck("units", "error", "the meshes have the size of the robot"),
    "C-KEYS": BareCheck("keyframes", "error", "each keyframe has a number for each coordinate"),
    "C-PLAUSIBLE": BareCheck("plausible", "warning", "nothing looks like a slip"),
}
"""The checks of the text and the figures of a bare file, by code, in the order of the report."""

Coded = tuple[str, Finding]
"""The code of a check, and what it does not accept."""

Look = Callable[[ModelDocument], Iterable[Coded]]
"""A part of the checks: what it finds in a document."""


def number(text: str | None) -> float | None:
    """A number; None where there is none (the checks of files say so)."""
    values = numbers(text)
    return values[0] if values is not None and len(values) == 1 else None


def numbers(text: str | None) -> list[float] | None:
    """Finite or infinite numbers; None where one is none."""
    try:
        values = [float(word) for word in (text or "").replace(",", " ").split()]
    except ValueError:
        return None
    return values if values and not any(value != value for value in values) else None


def coded(code: str, found: Iterable[Finding]) -> Iterator[Coded]:
    return ((code, one) for one in found)
