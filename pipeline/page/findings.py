"""Renders the diagnostics of a build, and the error that ended it, as HTML."""

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import escape

from linkwright.pipeline.page.codes import level_of, to_code
from linkwright.pipeline.page.html.tables import PageTable, table
from linkwright.pipeline.page.html.template import hint, marked, name, rendered, text
from linkwright.stages.robot.text.plural import count

LEVEL_TITLES = {"error": "Errors", "warning": "Warnings", "info": "For information"}
"""Level → the title of its section, in the order of the page."""

MAX_UNFOLDED = 8
"""Largest number of informational rows that are shown unfolded."""


def error_section(error: Mapping[str, Any] | None) -> str:
    """Renders the error that ended a build, with all its problems. Returns "" if there was no error."""
    if error is None:
        return ""
    problems = _table(error.get("problems", []))
    return rendered("error", **{"where": "", "hint": "", **error, "problems": problems})


def diagnostics_section(problems: Sequence[Mapping[str, Any]]) -> str:
    """Renders the diagnostics, grouped by level: errors, warnings, information. Returns "" if there are
    none."""
    groups = {
        level: [problem for problem in problems if level_of(problem["code"]) == level]
        for level in LEVEL_TITLES
    }
    sections = []
    for level, group in groups.items():
        if group:
            is_folded = level == "info" and len(group) > MAX_UNFOLDED
            fold_title = count(len(group), "diagnostic") if is_folded else ""
            sections.append({"title": LEVEL_TITLES[level], "table": _table(group), "folded": fold_title})
    return rendered("diagnostics", sections=sections) if sections else ""


def _table(problems: Sequence[Mapping[str, Any]]) -> PageTable | None:
    rows = [
        [
            marked(level_of(problem["code"]), to_code(problem["code"])),
            name(problem["where"]),
            escape(text(problem["message"])) + hint(problem["hint"]),
        ]
        for problem in problems
    ]
    return table(["code", "where", "message"], rows, {"code": "code", "where": "place"}, heads="code")
