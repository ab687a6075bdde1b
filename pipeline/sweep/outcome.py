"""The outcomes of the jobs of a sweep, and the closing table."""

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.pipeline.errors import exit_status
from linkwright.stages.robot.errors import LinkwrightError

if TYPE_CHECKING:
    from linkwright.pipeline.report import Report

REPORT = "report.json"

MOST_PROBLEMS = 3
"""So many problems of a job that failed are kept."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a job: its exit status, its message, and its folder.

    `overrides`: the overrides of the job, key → value; `figures`, `checks` (how many `passed`, and the
    names of those that `warned` and `failed`) and `calls` are those of its report, as far as there is one.
    `problems`: the first of those that its error has.
    """

    number: int
    label: str
    status: int
    message: str
    folder: str
    overrides: Mapping[str, Any] = field(default_factory=dict)
    figures: Mapping[str, float] = field(default_factory=dict)
    checks: Mapping[str, Any] = field(default_factory=dict)
    calls: Mapping[str, int] = field(default_factory=dict)
    problems: Sequence[str] = ()


def built(number: int, label: str, overrides: Mapping[str, Any], report: "Report") -> Outcome:
    """The outcome of a job with this report."""
    message = "valid" if report.until == "validate" else f"built up to {report.until}"
    if report.exit_status != 0:
        message = "not the newest state" if report.status == "stale" else "a check failed"
    failed = [check.name for check in report.failed_checks]
    warned = [check.name for check in report.warned_checks]
    passed = len(report.checks) - len(failed) - len(warned)
    checks = {"passed": passed, "warned": warned, "failed": failed} if report.checks else {}
    folder = os.path.relpath(report.folder)
    calls = _calls(report.calls)
    return Outcome(
        number, label, report.exit_status, message, folder, overrides, report.figures, checks, calls
    )


def failed(
    number: int, label: str, overrides: Mapping[str, Any], folder: str, error: BaseException
) -> Outcome:
    """The outcome of a job that ended with an error; its API calls are in the report of the failure."""
    name = "" if isinstance(error, LinkwrightError) else f"{type(error).__name__}: "
    message = f"{name}{error}".splitlines()[0]
    left = Path(f"{folder}.failed")
    place = left if left.is_dir() else Path(folder)
    try:
        report = json.loads((left / REPORT).read_bytes())
        if report["error"]["message"] not in (str(error), getattr(error, "message", "")):
            raise ValueError  # of an earlier build
        figures, calls = dict(report["figures"]), _calls(report["calls"])
    except (OSError, ValueError, KeyError, TypeError):
        figures, calls = {}, {}
    found = getattr(error, "problems", ())[:MOST_PROBLEMS]
    problems = [f"{one.code} {one.where}: {one.message}".replace(" : ", " ") for one in found]
    status = exit_status(error)
    return Outcome(number, label, status, message, str(place), overrides, figures, {}, calls, problems)


def _calls(report: Mapping[str, Any]) -> dict[str, int]:
    return {name: report[name] for name in ("made", "saved") if name in report}


def table(outcomes: Sequence[Outcome], root: Path) -> str:
    """The closing table."""
    rows: list[tuple[str, ...]] = [("job", "status", "", "what", "kg", "dof", "checks", "calls", "folder")]
    rows += [_row(outcome) for outcome in outcomes]
    used = [column for column in range(9) if column < 4 or any(row[column] for row in rows[1:])]
    widths = {column: max(len(row[column]) for row in rows) for column in used}
    lines = ["  ".join(row[column].ljust(widths[column]) for column in used).rstrip() for row in rows]
    good = sum(outcome.status == 0 for outcome in outcomes)
    return "\n".join([*lines, f"{good} of {len(outcomes)} jobs built and valid: {root}"])


def _row(one: Outcome) -> tuple[str, ...]:
    mass, dof = one.figures.get("mass"), one.figures.get("dof")
    checks = ""
    if one.checks:
        others = len(one.checks["warned"]) + len(one.checks["failed"])
        checks = f"{one.checks['passed']}/{one.checks['passed'] + others}"
    return (
        str(one.number),
        str(one.status),
        one.message,
        one.label,
        "" if mass is None else f"{mass:.4g}",
        "" if dof is None else str(int(dof)),
        checks,
        str(one.calls["made"]) if "made" in one.calls else "",
        one.folder,
    )


def sweep_status(outcomes: Iterable[Outcome]) -> int:
    """1 if any job failed, else 3 if any job's check failed, else 0."""
    found = {outcome.status for outcome in outcomes}
    if found - {0, 3}:
        return 1
    return 3 if 3 in found else 0
