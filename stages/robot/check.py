"""One check of a built robot: what was measured, against what limit, and where to look."""

from dataclasses import dataclass
from typing import Literal

CheckLevel = Literal["error", "warning"]
"""What a check that does not pass says: the robot is wrong; something could be better."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that a check does not accept. `element`: of the file, by tag and name, as `joint "elbow"`;
    `attribute`: of that element, "" where the element as a whole is meant."""

    element: str
    attribute: str
    message: str


@dataclass(frozen=True, slots=True)
class Table:
    """What a check found, row by row, whether it passes or not."""

    header: tuple[str, ...]
    rows: tuple[tuple[str | float | None, ...], ...]


@dataclass(frozen=True, slots=True)
class Check:
    """`value` and `limit` are in the unit that `detail` names; None where a check has no number. `code`: its
    row of `stages/CHECKS.md`. `findings`: what is wrong where it does not pass, the worst first. `table`:
    what was found beside that."""

    name: str
    passed: bool
    detail: str
    value: float | None = None
    limit: float | None = None
    code: str = ""
    level: CheckLevel = "error"
    findings: tuple[Finding, ...] = ()
    table: Table | None = None

    @property
    def fails(self) -> bool:
        """Whether it proves the robot wrong."""
        return not self.passed and self.level == "error"

    @property
    def warns(self) -> bool:
        """Whether it says that something could be better."""
        return not self.passed and self.level == "warning"
