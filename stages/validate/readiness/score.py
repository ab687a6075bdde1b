"""The score of a finished robot, as a check with a table of its points."""

from collections.abc import Iterator

from linkwright.stages.robot.check import Check, Finding, Table
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.readiness.finished import Aside, Finished
from linkwright.stages.validate.readiness.points import POINTS, Point

CODE = "C-READINESS"

HEADER = ("point", "what a model should have", "", "what would raise it, or why not")

PASSED, MISSING, ASIDE = "passed", "missing", "not applicable"

SHOWN = 5
"""So many faults of a point are named."""


def score(finished: Finished) -> Check:
    """It passes whatever the score is: it tells."""
    rows, findings = [], []
    for point in POINTS:
        verdict, words = judged(point, finished)
        rows.append((point.number, point.title, verdict, words))
        if verdict == MISSING:
            findings.append(Finding(f"point {point.number}", "", f"{point.title}: {words}"))
    passed = sum(verdict == PASSED for _, _, verdict, _ in rows)
    total = passed + len(findings)
    detail = f"{passed} of {count(total, 'point')}"
    if total < len(POINTS):
        apply = "does not apply" if len(POINTS) - total == 1 else "do not apply"
        detail += f" ({len(POINTS) - total} of the {len(POINTS)} {apply})"
    if findings:
        numbers = ", ".join(str(number) for number, _, verdict, _ in rows if verdict == MISSING)
        detail += f"; missing: {numbers}"
    name = f"{finished.path.name}: sim-readiness"
    table = Table(HEADER, tuple(rows))
    return Check(name, True, detail, float(passed), float(total), CODE, "warning", table=table)


def judged(point: Point, finished: Finished) -> tuple[str, str]:
    """A point's verdict, and the reason in words."""
    try:
        faults = list(_first(point, finished))
    except Aside as reason:
        return ASIDE, str(reason)
    except Exception as error:  # files may have been changed in any way
        return MISSING, f"it cannot be judged: {type(error).__name__}: {error}"
    more = f", and {len(faults) - SHOWN} more" if len(faults) > SHOWN else ""
    return (MISSING, "; ".join(faults[:SHOWN]) + more) if faults else (PASSED, "")


def _first(point: Point, finished: Finished) -> Iterator[str]:
    """The faults, each once."""
    yield from dict.fromkeys(point.judge(finished))
