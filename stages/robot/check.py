"""Describes the result of a check of a built robot: the measured value, its limit, and where to look."""

from dataclasses import dataclass
from typing import Literal

CheckLevel = Literal["error", "warning"]
"""The level of a check that does not pass. error: the robot is wrong; warning: it could be better."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A fault that a check finds in a file."""

    element: str
    """The tag and name of an element of the file, such as `joint "elbow"`."""
    attribute: str
    """An attribute of the element; "" for the element as a whole."""
    message: str
    """The fault in words."""


@dataclass(frozen=True, slots=True)
class Table:
    """The results of a check, row by row. Checks that pass have tables too."""

    header: tuple[str, ...]
    rows: tuple[tuple[str | float | None, ...], ...]


@dataclass(frozen=True, slots=True)
class Check:
    """The result of a check."""

    name: str
    passed: bool
    detail: str
    value: float | None = None
    """Measured value, in the unit that `detail` names; None if the check has no number."""
    limit: float | None = None
    """Limit of the value, in the same unit; None if the check has no number."""
    code: str = ""
    """The code of the check in `stages/CHECKS.md`; "" without a code."""
    level: CheckLevel = "error"
    findings: tuple[Finding, ...] = ()
    """The faults if the check does not pass, the worst first."""
    table: Table | None = None
    """Further results; None without a table."""

    @property
    def fails(self) -> bool:
        """Whether the check proves the robot wrong."""
        return not self.passed and self.level == "error"

    @property
    def warns(self) -> bool:
        """Whether the check says that something could be better."""
        return not self.passed and self.level == "warning"
