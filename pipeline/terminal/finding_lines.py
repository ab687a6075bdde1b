"""Writes diagnostics as lines of text, grouped by code, the worst of each code first."""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import sentence

MAX_FINDINGS = 3
"""Largest number of findings of a code that are shown."""

MAX_PASTED_LINES = 8
"""Largest number of lines of YAML that are shown for a code."""

_MAX_LENGTHS = {"W": 320, "I": 160}
"""Length of the longest message that is not shortened, by level; errors are never shortened."""

_LEVELS = "IWE"
"""The levels, the gravest last, where people look first."""

_VARYING_PART = re.compile(r"'[^']*'|\"[^\"]*\"|[\d.]+")
"""The parts in which two messages of the same form differ: names in quotes, and numbers."""


@dataclass(frozen=True, slots=True)
class Style:
    """The form in which findings are written."""

    rest: str
    """Where the other findings, and the rest of a shortened message, can be read."""

    whole: bool = False
    """Whether all findings are shown, and no message is shortened."""

    indent: str = ""
    hint: str = "    → "
    """The mark before a hint."""


def finding_lines(diagnostics: Iterable[Diagnostic], style: Style) -> list[str]:
    """Returns the lines of diagnostics, errors last. The diagnostics of a code keep their order."""
    groups: dict[str, list[Diagnostic]] = {}
    for diagnostic in diagnostics:
        groups.setdefault(diagnostic.code, []).append(diagnostic)
    codes = sorted(groups, key=lambda code: _LEVELS.index(code[0]))
    return [line for code in codes for line in _group(groups[code], style)]


def _group(group: Sequence[Diagnostic], style: Style) -> Iterator[str]:
    if style.whole or len(group) == 1:
        for diagnostic in group:
            yield _line(diagnostic, style)
            yield from _hint(diagnostic.hint, style)
        return
    shown = group[:MAX_FINDINGS]
    if _share_a_message(shown):
        yield _line(shown[0], style, f" ×{len(group)}")
        places = ", ".join(sentence(diagnostic.where) for diagnostic in shown[1:])
        yield f"{style.indent}    also: {places}{_and_more(len(group) - len(shown), style)}"
        yield from _hint(shown[0].hint.partition("\n")[0], style)
    else:
        for number, diagnostic in enumerate(shown):
            yield _line(diagnostic, style, "" if number else f" ×{len(group)}")
            if all(other.hint != diagnostic.hint for other in shown[number + 1 :]):
                yield from _hint(diagnostic.hint.partition("\n")[0], style)
        if remainder := _and_more(len(group) - len(shown), style):
            yield f"{style.indent}   {remainder}"
    yield from _yaml_to_paste(group, style)


def _share_a_message(shown: Sequence[Diagnostic]) -> bool:
    """Tells whether the places of findings tell them apart, so that a single message is enough."""
    places = {diagnostic.where for diagnostic in shown}
    forms = {
        _VARYING_PART.sub("", diagnostic.message.replace(diagnostic.where or " ", "")) for diagnostic in shown
    }
    return len(places) == len(shown) and "" not in places and len(forms) == 1


def _line(diagnostic: Diagnostic, style: Style, times: str = "") -> str:
    location = f" {sentence(diagnostic.where)}:" if diagnostic.where else ""
    message = sentence(diagnostic.message)
    limit = _MAX_LENGTHS.get(diagnostic.code[0], len(message))
    if len(message) > limit and not style.whole:
        message = f"{message[:limit].rpartition(' ')[0].rstrip(',;:')} … ({style.rest})"
    return f"{style.indent}{diagnostic.code}{times}{location} {message}"


def _hint(hint: str, style: Style) -> Iterator[str]:
    if hint:
        yield f"{style.indent}{style.hint}{hint}"


def _and_more(number: int, style: Style) -> str:
    return f" and {number} more ({style.rest})" if number > 0 else ""


def _yaml_to_paste(group: Sequence[Diagnostic], style: Style) -> Iterator[str]:
    """Yields the YAML that settles all findings of a code, which is below the hint of one of them."""
    for diagnostic in group:
        _, _, text = diagnostic.hint.partition("\n")
        lines = text.split("\n") if text else []
        if len(lines) > MAX_PASTED_LINES:
            yield f"{style.indent}{style.hint}{count(len(lines), 'line')} to paste, for all ({style.rest})"
        else:
            yield from lines
