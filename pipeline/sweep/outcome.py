"""Describes how a job of a sweep ended: its state, message, figures and checks."""

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from linkwright.pipeline.errors import exit_status
from linkwright.pipeline.reference.exit_status import BUILT, FAILED, UNMET
from linkwright.stages.robot.errors import LinkwrightError

if TYPE_CHECKING:
    from linkwright.pipeline.report import Report

REPORT = "report.json"

MAX_PROBLEMS = 3
"""Largest number of problems of a failed job that its outcome keeps."""


State = Literal["built", "unmet", "failed", "running", "missing"]
"""The state of a job: built and valid; built, but a check failed or the source was not the newest state;
ended by an error; started and not ended; not started."""

STATES: tuple[State, ...] = get_args(State)

RUNNING = "running"
MISSING = "missing"
"""The messages of jobs without an exit status: started and not ended; not started."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a job."""

    number: int
    label: str
    status: int | None
    """The exit status; None if the job has not ended."""

    message: str
    folder: str
    overrides: Mapping[str, Any] = field(default_factory=dict)
    """The overrides of the job: key → value."""

    figures: Mapping[str, float] = field(default_factory=dict)
    """The figures of the job's report, if there is one."""

    checks: Mapping[str, Any] = field(default_factory=dict)
    """The number of checks that `passed`, and the names of the checks that `warned` and that `failed`."""

    calls: Mapping[str, int] = field(default_factory=dict)
    """The numbers of API calls that the build `made`, and that the cache `saved`."""

    problems: tuple[str, ...] = ()
    """The first problems of the error that ended the job."""

    objective: float | None = None
    """The value that a search improves; None for a job without a single one."""

    @property
    def state(self) -> State:
        return state_of(self.status, self.message)

    @property
    def ended(self) -> bool:
        return self.status is not None


def state_of(status: int | None, message: str) -> State:
    """Returns the state of a job by its exit status and its message."""
    if status is None:
        return "running" if message == RUNNING else "missing"
    return "built" if status == BUILT else "unmet" if status == UNMET else "failed"


def missing_outcome(number: int, label: str, overrides: Mapping[str, Any], folder: str) -> Outcome:
    """Returns the outcome of a job that has left nothing."""
    return Outcome(number, label, None, MISSING, folder, overrides)


def built(number: int, label: str, overrides: Mapping[str, Any], report: "Report") -> Outcome:
    """Returns the outcome of a job with this report."""
    message = "valid" if report.until == "validate" else f"built up to {report.until}"
    if report.exit_status != 0:
        message = "not the newest state" if report.status == "stale" else "a check failed"
    failed = [check.name for check in report.failed_checks]
    warned = [check.name for check in report.warned_checks]
    passed = len(report.checks) - len(failed) - len(warned)
    checks = {"passed": passed, "warned": warned, "failed": failed} if report.checks else {}
    folder = os.path.relpath(report.folder)
    calls = _calls(report.calls)
    figures = {**report.figures, **report.objective}
    objective = next(iter(report.objective.values())) if len(report.objective) == 1 else None
    return Outcome(
        number,
        label,
        report.exit_status,
        message,
        folder,
        overrides,
        figures,
        checks,
        calls,
        objective=objective,
    )


def failed(
    number: int, label: str, overrides: Mapping[str, Any], folder: str, error: BaseException
) -> Outcome:
    """Returns the outcome of a job that ended with an error; its API calls are in the report of the
    failure."""
    name = "" if isinstance(error, LinkwrightError) else f"{type(error).__name__}: "
    message = f"{name}{error}".splitlines()[0]
    failure_folder = Path(f"{folder}.failed")
    # This also raises if the file system is out of reach, which is then the error.
    result_folder = failure_folder if os.path.isdir(failure_folder) else Path(folder)  # noqa: PTH112
    try:
        report = json.loads((failure_folder / REPORT).read_bytes())
        if report["error"]["message"] not in (str(error), getattr(error, "message", "")):
            raise ValueError  # of an earlier build
        figures, calls = dict(report["figures"]), _calls(report["calls"])
    except (OSError, ValueError, KeyError, TypeError):
        figures, calls = {}, {}
    diagnostics = getattr(error, "problems", ())[:MAX_PROBLEMS]
    problems = tuple(
        f"{problem.code} {problem.where}: {problem.message}".replace(" : ", " ") for problem in diagnostics
    )
    status = exit_status(error)
    return Outcome(
        number, label, status, message, str(result_folder), overrides, figures, {}, calls, problems
    )


def _calls(report: Mapping[str, Any]) -> dict[str, int]:
    return {name: report[name] for name in ("made", "saved") if name in report}


def sweep_status(outcomes: Iterable[Outcome]) -> int:
    """Returns the exit status of a sweep: 1 if any job failed or has not ended, else 3 if any job's check
    failed, else 0."""
    statuses = {outcome.status for outcome in outcomes}
    if statuses - {BUILT, UNMET}:
        return FAILED
    return UNMET if UNMET in statuses else BUILT
