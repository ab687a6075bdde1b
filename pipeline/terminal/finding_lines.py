"""Diagnostics as lines of text, in the terminal: those of a code together, of which the worst are shown."""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import sentence

MOST = 3
"""Findings of a code that are shown."""

MOST_TO_PASTE = 8
"""Lines of YAML that are shown for a code."""

_LETTERS = {"W": 320, "I": 160}
"""Longest message that is shown whole, by the level; an error always is."""

_LEVELS = "IWE"
"""The gravest last, where people look first."""

_VARIES = re.compile(r"'[^']*'|\"[^\"]*\"|[\d.]+")
"""What is different in two messages of one form: names in quotes, and numbers."""


@dataclass(frozen=True, slots=True)
class Style:
    """How findings are written: the indent of each, what stands before a hint, where the rest of them is, and
    whether all are shown whole."""

    rest: str
    whole: bool = False
    indent: str = ""
    hint: str = "    → "


def finding_lines(found: Iterable[Diagnostic], style: Style) -> list[str]:
    """The lines of diagnostics, the gravest last; those of a code stay in their order, the worst first."""
    groups: dict[str, list[Diagnostic]] = {}
    for diagnostic in found:
        groups.setdefault(diagnostic.code, []).append(diagnostic)
    codes = sorted(groups, key=lambda code: _LEVELS.index(code[0]))
    return [line for code in codes for line in _group(groups[code], style)]


def _group(group: Sequence[Diagnostic], style: Style) -> Iterator[str]:
    if style.whole or len(group) == 1:
        for diagnostic in group:
            yield _line(diagnostic, style)
            yield from _hint(diagnostic.hint, style)
        return
    shown = group[:MOST]
    if _are_alike(shown):
        yield _line(shown[0], style, f" ×{len(group)}")
        others = ", ".join(sentence(diagnostic.where) for diagnostic in shown[1:])
        yield f"{style.indent}    also: {others}{_and_more(len(group) - len(shown), style)}"
        yield from _hint(shown[0].hint.partition("\n")[0], style)
    else:
        for number, diagnostic in enumerate(shown):
            yield _line(diagnostic, style, "" if number else f" ×{len(group)}")
            if all(other.hint != diagnostic.hint for other in shown[number + 1 :]):
                yield from _hint(diagnostic.hint.partition("\n")[0], style)
        if more := _and_more(len(group) - len(shown), style):
            yield f"{style.indent}   {more}"
    yield from _to_paste(group, style)


def _are_alike(shown: Sequence[Diagnostic]) -> bool:
    """Whether the places of findings tell them apart, so that one message will do."""
    places = {diagnostic.where for diagnostic in shown}
    forms = {_VARIES.sub("", diagnostic.message.replace(diagnostic.where or " ", "")) for diagnostic in shown}
    return len(places) == len(shown) and "" not in places and len(forms) == 1


def _line(diagnostic: Diagnostic, style: Style, times: str = "") -> str:
    place = f" {sentence(diagnostic.where)}:" if diagnostic.where else ""
    message = sentence(diagnostic.message)
    most = _LETTERS.get(diagnostic.code[0], len(message))
    if len(message) > most and not style.whole:
        message = f"{message[:most].rpartition(' ')[0].rstrip(',;:')} … ({style.rest})"
    return f"{style.indent}{diagnostic.code}{times}{place} {message}"


def _hint(hint: str, style: Style) -> Iterator[str]:
    if hint:
        yield f"{style.indent}{style.hint}{hint}"


def _and_more(number: int, style: Style) -> str:
    return f" and {number} more ({style.rest})" if number > 0 else ""


def _to_paste(group: Sequence[Diagnostic], style: Style) -> Iterator[str]:
    """The YAML that settles all of a code, which is below the hint of one of them."""
    for diagnostic in group:
        _, _, text = diagnostic.hint.partition("\n")
        lines = text.split("\n") if text else []
        if len(lines) > MOST_TO_PASTE:
            yield f"{style.indent}{style.hint}{count(len(lines), 'line')} to paste, for all ({style.rest})"
        else:
            yield from lines
