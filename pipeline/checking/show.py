"""Shows the verdict of checks as text."""

from linkwright.pipeline.checking.verdict import Verdict
from linkwright.pipeline.terminal.check_text import check_lines, tally
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import printable

MAX_FINDINGS = 10
"""Largest number of findings of a check in the text."""


def as_text(verdict: Verdict) -> str:
    """Returns a text with a paragraph for each check that does not pass, the gravest last, followed by the
    numbers of known findings and of passed checks."""
    lines = [printable(note) for note in verdict.notes]
    new = [check for check in verdict.checks if not check.passed and not verdict.is_known(check)]
    for word, is_failure in (("WARNING", False), ("FAILED", True)):
        for check in new:
            if verdict.is_wrong(check) == is_failure:
                new_findings = verdict.with_new_findings(check)
                lines += check_lines(
                    word, new_findings, MAX_FINDINGS, ": --json has all", figures(new_findings)
                )
    if verdict.baseline is not None:
        lines.append(f"{count(verdict.known_count, 'finding')} known from the baseline")
    return "\n".join([*lines, tally(verdict.checks)])


def figures(check: Check) -> str:
    """Returns the measured value and its limit as text; "" for a check without numbers."""
    if check.value is None or check.limit is None:
        return ""
    return f"{check.value:.6g}, at most {check.limit:.6g}"
