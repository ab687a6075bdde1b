"""The checks of a build: those that failed, those that warn, and those that passed, folded."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.codes import to_code
from linkwright.pipeline.page.html.markup import folded, plain_table, section, table, text

OUTCOMES = ("failed", "warning", "passed")
"""Of a check, the gravest first."""

_MARKS = {"failed": "✕ failed", "warning": "! warning", "passed": "✓ passed"}


_ON_PAPER = 16
"""Rows of a check's own table from which it is left out on paper."""


def checks(found: Sequence[Mapping[str, Any]]) -> str:
    """The section; nothing without checks."""
    groups = {word: [check for check in found if outcome(check) == word] for word in OUTCOMES}
    passed = groups["passed"]
    words = f'<span class="passed">✓ {len(passed)} passed</span>'
    unmet = [check for word in OUTCOMES if word != "passed" for check in groups[word]]
    own = "".join(_own_table(check) for check in found if check.get("table"))
    body = _table(unmet) + folded(words, _table(passed), on_paper=False) + own
    return section(f"Checks: {tally(found)}", body, "checks") if found else ""


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


def _own_table(check: Mapping[str, Any]) -> str:
    """What a check found beside what it does not accept."""
    rows = [["" if cell is None else cell for cell in row] for row in check["table"]["rows"]]
    summary = f"{split_name(check)[1]}: {check['detail']}".removeprefix(": ")
    shown = plain_table(check["table"]["header"], rows)
    return folded(text(summary), shown, on_paper=len(rows) <= _ON_PAPER)


def said(finding: Mapping[str, Any]) -> str:
    """What a check does not accept, of which element and attribute."""
    return f"{finding['element']} {finding['attribute']}".strip() + f": {finding['message']}"


def _found_by(check: Mapping[str, Any]) -> str:
    """What a check measured, and the elements and attributes to look at."""
    return text(check["detail"]) + "".join(f"<br>{text(said(one))}" for one in check["findings"])


def _table(group: Sequence[Mapping[str, Any]]) -> str:
    """A row for each check; files in which one comes to exactly the same share its row."""
    files: dict[tuple[Any, ...], list[str]] = {}
    for check in group:
        file, title = split_name(check)
        same = (outcome(check), check["code"], title, _found_by(check), check["value"], check["limit"])
        files.setdefault(same, []).append(file)
    rows = []
    for (word, code, title, found, *figures), where in files.items():
        name = text(title) if word == "passed" else to_code(code, title)
        cells = [name, text(", ".join(filter(None, where))), found, *map(text, figures)]
        rows.append([f'<span class="{word}">{_MARKS[word]}</span>', *cells])
    header = ["", "check", "of", "found", "value", "limit"]
    return table(header, rows, {"": "word", "value": "number", "limit": "number"}, heads="check")
