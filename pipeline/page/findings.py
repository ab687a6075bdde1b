"""The diagnostics of a build, and what ended it."""

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import escape

from linkwright.pipeline.page.codes import level_of, to_code
from linkwright.pipeline.page.html.tables import PageTable, table
from linkwright.pipeline.page.html.template import hint, marked, name, rendered, text
from linkwright.stages.robot.text.plural import count

LEVELS = {"error": "Errors", "warning": "Warnings", "info": "For information"}

OPEN = 8
"""So many rows for information are in sight."""


def error(found: Mapping[str, Any] | None) -> str:
    """What ended a failed build, with all that is to be settled; nothing without an error."""
    if found is None:
        return ""
    problems = _table(found.get("problems", []))
    return rendered("error", **{"where": "", "hint": "", **found, "problems": problems})


def diagnostics(found: Sequence[Mapping[str, Any]]) -> str:
    """The diagnostics, the gravest first."""
    groups = {level: [one for one in found if level_of(one["code"]) == level] for level in LEVELS}
    parts = [
        {
            "title": LEVELS[level],
            "table": _table(group),
            "folded": count(len(group), "diagnostic") if level == "info" and len(group) > OPEN else "",
        }
        for level, group in groups.items()
        if group
    ]
    return rendered("diagnostics", parts=parts) if parts else ""


def _table(problems: Sequence[Mapping[str, Any]]) -> PageTable | None:
    rows = [
        [
            marked(level_of(one["code"]), to_code(one["code"])),
            name(one["where"]),
            escape(text(one["message"])) + hint(one["hint"]),
        ]
        for one in problems
    ]
    return table(["code", "where", "what"], rows, {"code": "code", "where": "place"}, heads="code")
