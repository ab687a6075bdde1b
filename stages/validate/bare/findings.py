"""Lists the checks of a bare file, whose results are findings with the code of their check."""

from dataclasses import dataclass

from linkwright.stages.robot.check import CheckLevel, Finding


@dataclass(frozen=True, slots=True)
class BareCheck:
    """A check of a bare file."""

    name: str
    level: CheckLevel
    passed: str
    """The message if there are no findings."""


CHECKS = {
    "C-TREE": BareCheck("tree", "error", "the links are one tree, from one root"),
    "C-MIMIC": BareCheck("mimics", "error", "no joint follows itself"),
    "C-DIRECTION": BareCheck("directions", "error", "every axis and quaternion has a direction"),
    "C-LIMIT": BareCheck(
        "limits", "error", "every range rises, and no damping, friction, effort or gain is negative"
    ),
    "C-SOLID": BareCheck("inertials", "error", "every mass is positive, every inertia that of a solid"),
    "C-UNITS": BareCheck("units", "error", "the meshes have the size of the robot"),
    "C-KEYS": BareCheck("keyframes", "error", "each keyframe has a number for each coordinate"),
    "C-PLAUSIBLE": BareCheck("plausible", "warning", "nothing looks like a slip"),
}
"""The checks of the text and the figures of a bare file, by code, in the order of the report."""

Coded = tuple[str, Finding]
"""The code of a check, and a finding."""


def number(text: str | None) -> float | None:
    """Returns the number in a text; None if the text is not a number, which the checks of files report."""
    values = numbers(text)
    return values[0] if values is not None and len(values) == 1 else None


def numbers(text: str | None) -> list[float] | None:
    """Returns the numbers in a text, infinite numbers too; None if a word is not a number."""
    try:
        values = [float(word) for word in (text or "").replace(",", " ").split()]
    except ValueError:
        return None
    return values if values and not any(value != value for value in values) else None
