"""The diagnostics of a build, and what ended it."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.codes import level_of, to_code
from linkwright.pipeline.page.html.markup import folded, name, part, section, table, text
from linkwright.stages.robot.text.plural import count

LEVELS = {"error": "Errors", "warning": "Warnings", "info": "For information"}

OPEN = 8
"""So many rows for information are in sight."""


def error(found: Mapping[str, Any] | None) -> str:
    """What ended a failed build, with all that is to be settled; nothing without an error."""
    if found is None:
        return ""
    place = f"{text(found['where'])}: " if found.get("where") else ""
    message = f'<p class="error">{place}{text(found["message"])}</p>\n{hint(found.get("hint", ""))}'
    return section(text(found["type"]), message + _table(found.get("problems", [])), "error")


def diagnostics(found: Sequence[Mapping[str, Any]]) -> str:
    """The diagnostics, the gravest first."""
    groups = {level: [one for one in found if level_of(one["code"]) == level] for level in LEVELS}
    parts = []
    for level, group in groups.items():
        rows = _table(group)
        many = level == "info" and len(group) > OPEN
        shown = folded(count(len(group), "diagnostic"), rows, on_paper=False) if many else rows
        parts.append(part(LEVELS[level], shown))
    return section("Diagnostics", "\n".join(filter(None, parts)), "diagnostics")


def _table(problems: Sequence[Mapping[str, Any]]) -> str:
    rows = [[_code(one), name(one["where"]), text(one["message"]) + hint(one["hint"])] for one in problems]
    return table(["code", "where", "what"], rows, {"code": "code", "where": "place"}, heads="code")


def _code(diagnostic: Mapping[str, Any]) -> str:
    code = diagnostic["code"]
    return f'<span class="{level_of(code)}">{to_code(code)}</span>'


def hint(words: str) -> str:
    """What to do, on a line of its own."""
    return f'<span class="hint">→ {text(words)}</span>' if words else ""
