"""Lists the checks of a bare file, a URDF or MJCF by itself, and parses the numbers in it.

The result of a check is a list of findings with the code of the check.
"""

import math
from dataclasses import dataclass

from linkwright.stages.robot.check import CheckLevel, Finding


@dataclass(frozen=True, slots=True)
class BareCheck:
    """A check of a bare file."""

    name: str
    """The name of its result in the report."""

    level: CheckLevel
    """The level of its findings."""

    passed_text: str
    """The message if there are no findings."""


BARE_CHECKS = {
    "C-TREE": BareCheck("tree", "error", "the links form one tree, from one root"),
    "C-MIMIC": BareCheck("mimics", "error", "no joint follows itself"),
    "C-DIRECTION": BareCheck("directions", "error", "every axis and quaternion has a direction"),
    "C-LIMIT": BareCheck(
        "limits", "error", "every range rises, and no damping, friction, effort or gain is negative"
    ),
    "C-SOLID": BareCheck(
        "inertials", "error", "every moving mass is positive, and every inertia is that of a solid body"
    ),
    "C-UNITS": BareCheck("units", "error", "no mesh is far larger than the robot"),
    "C-KEYS": BareCheck("keyframes", "error", "each keyframe has a number for each coordinate and control"),
    "C-PLAUSIBLE": BareCheck("plausible", "warning", "no value looks like a slip"),
}
"""The checks of the text and the figures of a bare file, by code, in the order of the report."""

CodedFinding = tuple[str, Finding]
"""A finding with the code of its check, an entry of `BARE_CHECKS`."""


def parse_number(text: str | None) -> float | None:
    """Returns the number in a text; None if the text is not a single number, a fault that
    other checks report."""
    values = parse_numbers(text)
    return values[0] if values is not None and len(values) == 1 else None


def parse_numbers(text: str | None) -> list[float] | None:
    """Returns the numbers in a text, separated by white space or commas, infinite numbers included. Returns
    None for an empty or missing text, and if a word is not a number."""
    try:
        values = [float(word) for word in (text or "").replace(",", " ").split()]
    except ValueError:
        return None
    return values if values and not any(map(math.isnan, values)) else None
