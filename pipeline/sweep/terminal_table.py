"""Lays out the closing table of a sweep: it fits the terminal's width, and has at most forty rows."""

from collections.abc import Sequence
from pathlib import Path

from linkwright.pipeline.sweep.outcome import Outcome
from linkwright.pipeline.sweep.summary_csv import FILE_NAME
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import columns, sentence

MAX_ROWS = 40

_TITLES = ("job", "status", "", "what", "kg", "dof", "checks", "calls", "folder")
_FIXED_COLUMNS = 4
"""Number of first columns that are shown even if they are empty."""

_SHORTENABLE_COLUMNS = (2, 3, 8)
"""The columns whose texts are shortened if the width is too small."""

_MIN_WIDTH = 8
"""Smallest width of the long columns while there are other columns that can be dropped."""

_DROP_ORDER = (7, 5, 6, 4, 8)
"""The columns that are dropped if shorter texts are not enough, in this order."""

_GAP = 2

_WORST_FIRST = ("failed", "unmet", "running", "missing", "built")
"""The states in the order in which jobs are chosen."""


def table(outcomes: Sequence[Outcome], root: Path, width: int | None = None) -> str:
    """Returns the table, of at most `width` columns (None: without limit)."""
    chosen = _choose_jobs(outcomes)
    rows = [_TITLES, *(_row(outcome) for outcome in chosen)]
    shown_columns = [
        column
        for column in range(len(_TITLES))
        if column < _FIXED_COLUMNS or any(row[column] for row in rows[1:])
    ]
    widths = _fit_widths(
        {column: max(columns(row[column]) for row in rows) for column in shown_columns}, width
    )
    lines = [
        (" " * _GAP).join(_pad(row[column], size) for column, size in widths.items()).rstrip() for row in rows
    ]
    if len(chosen) < len(outcomes):
        lines.append(_remainder_line(outcomes, chosen, root))
    valid_count = sum(outcome.status == 0 for outcome in outcomes)
    return "\n".join([*lines, f"{valid_count} of {len(outcomes)} jobs built and valid: {root}"])


def _choose_jobs(outcomes: Sequence[Outcome]) -> list[Outcome]:
    """Returns the jobs that the table shows: all of them, or those in the worst states. Of a state that does
    not fit it shows a sample at even distances."""
    if len(outcomes) <= MAX_ROWS:
        return list(outcomes)
    chosen: list[Outcome] = []
    for state in _WORST_FIRST:
        room = MAX_ROWS - len(chosen)
        jobs = [outcome for outcome in outcomes if outcome.state == state]
        # Unfinished jobs leave room for a sample of those that were built.
        if state in ("running", "missing"):
            room = (room + 1) // 2
        chosen += jobs if len(jobs) <= room else [jobs[index * len(jobs) // room] for index in range(room)]
    return chosen


def _remainder_line(outcomes: Sequence[Outcome], chosen: Sequence[Outcome], root: Path) -> str:
    """Returns the line below a shortened table: how many jobs of each state it leaves out, and the file that
    lists all jobs."""
    counts = []
    for state in _WORST_FIRST:
        number = sum(outcome.state == state for outcome in outcomes)
        number -= sum(outcome.state == state for outcome in chosen)
        counts += [f"{number} {_WORDS[state]}"] if number else []
    left_out_count = len(outcomes) - len(chosen)
    return f"and {count(left_out_count, 'more job')} ({', '.join(counts)}): {root / FILE_NAME}"


_WORDS = {
    "failed": "failed",
    "unmet": "with a check that failed",
    "running": "running",
    "missing": "missing",
    "built": "built",
}


def _row(outcome: Outcome) -> tuple[str, ...]:
    mass, dof = outcome.figures.get("mass"), outcome.figures.get("dof")
    checks = ""
    if outcome.checks:
        not_passed = len(outcome.checks["warned"]) + len(outcome.checks["failed"])
        checks = f"{outcome.checks['passed']}/{outcome.checks['passed'] + not_passed}"
    return (
        str(outcome.number),
        "" if outcome.status is None else str(outcome.status),
        sentence(outcome.message),
        sentence(outcome.label),
        "" if mass is None else f"{mass:.4g}",
        "" if dof is None else str(int(dof)),
        checks,
        str(outcome.calls["made"]) if "made" in outcome.calls else "",
        outcome.folder,
    )


def _fit_widths(widths: dict[int, int], limit: int | None) -> dict[int, int]:
    """Returns the widths of the columns, reduced to fit: the longest texts are shortened first."""

    def excess() -> int:
        return sum(widths.values()) + _GAP * (len(widths) - 1) - limit if limit else 0

    for dropped in (None, *_DROP_ORDER):
        if dropped in widths and excess() > 0:
            del widths[dropped]
        minimum = _MIN_WIDTH if widths.keys() & set(_DROP_ORDER) else 1
        while excess() > 0:
            longest = max(
                (column for column in _SHORTENABLE_COLUMNS if column in widths), key=widths.__getitem__
            )
            if widths[longest] <= minimum:
                break
            widths[longest] -= 1
    return widths


def _pad(words: str, width: int) -> str:
    while columns(words) > width:
        words = f"{words.rstrip('…')[:-1]}…"
    return words + " " * (width - columns(words))
