"""Writes a check as lines of text."""

from collections.abc import Sequence

from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import sentence


def check_lines(word: str, check: Check, max_findings: int, rest: str, measured: str = "") -> list[str]:
    """Returns the lines of a check that did not pass, with a remedy. `word`: FAILED or WARNING;
    `max_findings`: the largest number of findings; `rest`: a text that tells where the other findings are;
    `measured`: the measured value."""
    code = f"{check.code} " if check.code else ""
    figures = f" ({measured})" if measured else ""
    lines = [sentence(f"{word} {code}{check.name}: {check.detail}{figures}")]
    for finding in check.findings[:max_findings]:
        attribute = f" {finding.attribute}" if finding.attribute else ""
        lines.append(sentence(f"    {finding.element}{attribute}: {finding.message}"))
    left_out = len(check.findings) - max_findings
    lines += [f"    and {left_out} more{rest}"] if left_out > 0 else []
    hint = remedy(check.code)
    return lines + ([f"    → {hint}"] if hint else [])


def tally(checks: Sequence[Check]) -> str:
    """Returns a phrase with the number of checks that passed."""
    return f"{sum(check.passed for check in checks)} of {count(len(checks), 'check')} passed"
