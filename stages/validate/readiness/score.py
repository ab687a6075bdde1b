"""Scores the readiness of a finished robot, as a check with a table of the points."""

from collections.abc import Sequence
from typing import NamedTuple

from linkwright.stages.robot.check import Check, Table
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.readiness.finished import FinishedRobot, NotApplicable
from linkwright.stages.validate.readiness.points import POINTS, Point

CODE = "C-READINESS"

HEADER = ("point", "what a model should have", "", "what would raise it, or why not")
"""The table's columns: number and title of a point, its verdict, and the faults or the reason."""

PASSED, MISSING, NOT_APPLICABLE = "passed", "missing", "not applicable"

MAX_FAULTS = 5
"""Largest number of faults that are listed for a point."""


def score(finished: FinishedRobot) -> Check:
    """Scores a finished robot. The check always passes, since the score only informs."""
    judgements = [_JudgedPoint(point, *judge_point(point, finished)) for point in POINTS]
    passed = sum(judgement.verdict == PASSED for judgement in judgements)
    total = sum(judgement.verdict != NOT_APPLICABLE for judgement in judgements)
    name = f"{finished.path.name}: sim-readiness"
    rows = tuple(
        (judgement.point.number, judgement.point.title, judgement.verdict, judgement.reason)
        for judgement in judgements
    )
    detail, table = _detail(judgements, passed, total), Table(HEADER, rows)
    return Check(name, True, detail, float(passed), float(total), CODE, "warning", table=table)


class _JudgedPoint(NamedTuple):
    """A point with its verdict."""

    point: Point
    verdict: str
    reason: str


def _detail(judgements: Sequence[_JudgedPoint], passed: int, total: int) -> str:
    """Returns the score as text. `passed`, `total`: the numbers of the points that pass and that apply."""
    detail = f"{passed} of {count(total, 'point')}"
    inapplicable = len(judgements) - total
    if inapplicable:
        verb = "does not apply" if inapplicable == 1 else "do not apply"
        detail += f" ({inapplicable} of the {len(judgements)} {verb})"
    missing = [str(judgement.point.number) for judgement in judgements if judgement.verdict == MISSING]
    return f"{detail}; missing: {', '.join(missing)}" if missing else detail


def judge_point(point: Point, finished: FinishedRobot) -> tuple[str, str]:
    """Returns a point's verdict, and the reason as text."""
    faults_in_order: dict[str, None] = {}
    try:
        for fault in point.judge(finished):
            faults_in_order[fault] = None
    except NotApplicable as reason:
        # A fault that was found before counts, even if the rest of the point does not apply.
        if not faults_in_order:
            return NOT_APPLICABLE, str(reason)
    except Exception as error:  # files may have been changed in any way
        return MISSING, f"it cannot be judged: {type(error).__name__}: {error}"
    faults = list(faults_in_order)
    remainder = f", and {len(faults) - MAX_FAULTS} more" if len(faults) > MAX_FAULTS else ""
    return (MISSING, "; ".join(faults[:MAX_FAULTS]) + remainder) if faults else (PASSED, "")
