"""The checks of a build: those that failed, those that warn, and those that passed, folded."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.codes import to_code
from linkwright.pipeline.page.html.tables import PageTable, plain_table, table
from linkwright.pipeline.page.html.template import marked, rendered, stacked

OUTCOMES = ("failed", "warning", "passed")
"""Of a check, the gravest first."""

_MARKS = {"failed": "✕ failed", "warning": "! warning", "passed": "✓ passed"}


_ON_PAPER = 16
"""Rows of a check's own table from which it is left out on paper."""


def checks(found: Sequence[Mapping[str, Any]]) -> str:
    """The section; nothing without checks."""
    groups = {word: [check for check in found if outcome(check) == word] for word in OUTCOMES}
    unmet = [check for word in OUTCOMES if word != "passed" for check in groups[word]]
    own = [_own_table(check) for check in found if check.get("table")]
    passed, number = _table(groups["passed"]), len(groups["passed"])
    values = {"tally": tally(found), "unmet": _table(unmet), "passed": passed, "number": number, "own": own}
    return rendered("checks", **values) if found else ""


def tally(found: Sequence[Mapping[str, Any]], what: str = "") -> str:
    """How many of the checks passed, and what the others did; `what`: what the number counts."""
    words = [outcome(check) for check in found]
    said = f"{words.count('passed')} of {len(found)}{what} passed"
    warn = words.count("warning")
    others = [f"{words.count('failed')} failed"] if "failed" in words else []
    others += [f"{warn} {'warns' if warn == 1 else 'warn'}"] if warn else []
    return ", ".join([said, *others])


def outcome(check: Mapping[str, Any]) -> str:
    """Which of the outcomes a check has."""
    if check["passed"]:
        return "passed"
    return "failed" if check["level"] == "error" else "warning"


def split_name(check: Mapping[str, Any]) -> tuple[str, str]:
    """The file that a check is about ("" for none), and its title."""
    file, _, title = check["name"].rpartition(": ")
    return file, title


def _own_table(check: Mapping[str, Any]) -> dict[str, Any]:
    """What a check found beside what it does not accept."""
    rows = check["table"]["rows"]
    summary = f"{split_name(check)[1]}: {check['detail']}".removeprefix(": ")
    shown = plain_table(check["table"]["header"], rows)
    return {"summary": summary, "table": shown, "brief": len(rows) > _ON_PAPER}


def said(finding: Mapping[str, Any]) -> str:
    """What a check does not accept, of which element and attribute."""
    return f"{finding['element']} {finding['attribute']}".strip() + f": {finding['message']}"


def _table(group: Sequence[Mapping[str, Any]]) -> PageTable | None:
    """A row for each check; files in which one comes to exactly the same share its row."""
    files: dict[tuple[Any, ...], list[str]] = {}
    for check in group:
        file, title = split_name(check)
        found = stacked([check["detail"], *map(said, check["findings"])])
        same = (outcome(check), check["code"], title, found, check["value"], check["limit"])
        files.setdefault(same, []).append(file)
    rows = []
    for (word, code, title, found, *figures), where in files.items():
        name = title if word == "passed" else to_code(code, title)
        rows.append([marked(word, _MARKS[word]), name, ", ".join(filter(None, where)), found, *figures])
    header = ["", "check", "of", "found", "value", "limit"]
    return table(header, rows, {"": "word", "value": "number", "limit": "number"}, heads="check")
