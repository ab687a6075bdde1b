"""A check as lines of text, in the terminal."""

from collections.abc import Sequence

from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import sentence


def check_lines(word: str, check: Check, most: int, rest: str, measured: str = "") -> list[str]:
    """A check that did not pass, with what was `measured`, at most so many of its findings, where the `rest`
    are, and what to do."""
    code = f"{check.code} " if check.code else ""
    figures = f" ({measured})" if measured else ""
    lines = [sentence(f"{word} {code}{check.name}: {check.detail}{figures}")]
    for found in check.findings[:most]:
        attribute = f" {found.attribute}" if found.attribute else ""
        lines.append(sentence(f"    {found.element}{attribute}: {found.message}"))
    more = len(check.findings) - most
    lines += [f"    and {more} more{rest}"] if more > 0 else []
    hint = remedy(check.code)
    return lines + ([f"    → {hint}"] if hint else [])


def tally(checks: Sequence[Check]) -> str:
    """How many of the checks passed, in words."""
    return f"{sum(check.passed for check in checks)} of {count(len(checks), 'check')} passed"
