"""Scores the readiness of a finished robot, as a check with a table of the points."""

from collections.abc import Iterator

from linkwright.stages.robot.check import Check, Finding, Table
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.readiness.finished import Finished, NotApplicable
from linkwright.stages.validate.readiness.points import POINTS, Point

CODE = "C-READINESS"

HEADER = ("point", "what a model should have", "", "what would raise it, or why not")

PASSED, MISSING, NOT_APPLICABLE = "passed", "missing", "not applicable"

MAX_FAULTS = 5
"""Largest number of faults that are listed for a point."""


def score(finished: Finished) -> Check:
    """Scores a finished robot. The check always passes, since the score only informs."""
    rows, findings = [], []
    for point in POINTS:
        verdict, reason = judge_point(point, finished)
        rows.append((point.number, point.title, verdict, reason))
        if verdict == MISSING:
            findings.append(Finding(f"point {point.number}", "", f"{point.title}: {reason}"))
    passed = sum(verdict == PASSED for _, _, verdict, _ in rows)
    total = passed + len(findings)
    detail = f"{passed} of {count(total, 'point')}"
    if total < len(POINTS):
        verb = "does not apply" if len(POINTS) - total == 1 else "do not apply"
        detail += f" ({len(POINTS) - total} of the {len(POINTS)} {verb})"
    if findings:
        numbers = ", ".join(str(number) for number, _, verdict, _ in rows if verdict == MISSING)
        detail += f"; missing: {numbers}"
    name = f"{finished.path.name}: sim-readiness"
    table = Table(HEADER, tuple(rows))
    return Check(name, True, detail, float(passed), float(total), CODE, "warning", table=table)


def judge_point(point: Point, finished: Finished) -> tuple[str, str]:
    """Returns a point's verdict, and the reason as text."""
    try:
        faults = list(_faults(point, finished))
    except NotApplicable as reason:
        return NOT_APPLICABLE, str(reason)
    except Exception as error:  # files may have been changed in any way
        return MISSING, f"it cannot be judged: {type(error).__name__}: {error}"
    remainder = f", and {len(faults) - MAX_FAULTS} more" if len(faults) > MAX_FAULTS else ""
    return (MISSING, "; ".join(faults[:MAX_FAULTS]) + remainder) if faults else (PASSED, "")


def _faults(point: Point, finished: Finished) -> Iterator[str]:
    """Yields each fault of a point once."""
    yield from dict.fromkeys(point.judge(finished))
