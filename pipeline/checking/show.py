"""The verdict of checks as text."""

from linkwright.pipeline.checking.verdict import Verdict
from linkwright.pipeline.terminal.check_text import check_lines, tally
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import printable

MOST_FINDINGS = 10
"""Of a check, in the text."""


def as_text(verdict: Verdict) -> str:
    """A paragraph for each check that does not pass, the gravest last; then how many are known, and how many
    passed."""
    lines = [printable(note) for note in verdict.notes]
    new = [check for check in verdict.checks if not check.passed and not verdict.is_known(check)]
    for word, wrong in (("WARNING", False), ("FAILED", True)):
        for check in new:
            if verdict.is_wrong(check) == wrong:
                news = verdict.news(check)
                lines += check_lines(word, news, MOST_FINDINGS, ": --json has all", figures(news))
    if verdict.known is not None:
        lines.append(f"{count(verdict.seen_before, 'finding')} known from the baseline")
    return "\n".join([*lines, tally(verdict.checks)])


def figures(check: Check) -> str:
    """What was measured and against what, "" where there is no number."""
    if check.value is None or check.limit is None:
        return ""
    return f"{check.value:.6g}, at most {check.limit:.6g}"
