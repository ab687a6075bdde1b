"""One check of a built robot: what was measured, against what limit."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Check:
    """`value` and `limit` are in the unit that `detail` names; None where a check has no number."""

    name: str
    passed: bool
    detail: str
    value: float | None = None
    limit: float | None = None
