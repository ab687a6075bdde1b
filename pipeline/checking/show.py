"""The verdict of checks as text."""

from pipeline.checking.verdict import Verdict
from pipeline.reference.codes import remedy
from stages.robot.check import Check
from stages.robot.plural import count
from stages.robot.printable import printable

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
                lines += _lines(word, verdict.news(check))
    if verdict.known is not None:
        lines.append(f"{count(verdict.seen_before, 'finding')} known from the baseline")
    passed = sum(check.passed for check in verdict.checks)
    return "\n".join([*lines, f"{passed} of {count(len(verdict.checks), 'check')} passed"])


def figures(check: Check) -> str:
    """What was measured and against what, "" where there is no number."""
    if check.value is None or check.limit is None:
        return ""
    return f"{check.value:.6g}, at most {check.limit:.6g}"


def _lines(word: str, check: Check) -> list[str]:
    measured = figures(check)
    head = f"{word} {check.code} {check.name}: {check.detail}" + (f" ({measured})" if measured else "")
    lines = [printable(head)]
    for found in check.findings[:MOST_FINDINGS]:
        attribute = f" {found.attribute}" if found.attribute else ""
        lines.append(printable(f"    {found.element}{attribute}: {found.message}"))
    more = len(check.findings) - MOST_FINDINGS
    lines += [f"    and {more} more: --json has all"] if more > 0 else []
    hint = remedy(check.code)
    return lines + ([f"    → {hint}"] if hint else [])
