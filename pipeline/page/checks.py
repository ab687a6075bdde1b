"""Renders the checks of a build: those that failed, those that warn, and those that passed, folded."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.codes import to_code
from linkwright.pipeline.page.html.tables import PageTable, plain_table, table
from linkwright.pipeline.page.html.template import marked, rendered, stacked

OUTCOMES = ("failed", "warning", "passed")
"""The outcomes of a check, the gravest first."""

_MARKS = {"failed": "✕ failed", "warning": "! warning", "passed": "✓ passed"}


MAX_PRINTED_ROWS = 16
"""Largest number of rows of a check's own table that are printed on paper."""


def checks(results: Sequence[Mapping[str, Any]]) -> str:
    """Renders the section; "" without checks."""
    by_outcome = {word: [check for check in results if outcome(check) == word] for word in OUTCOMES}
    unmet_checks = [check for word in OUTCOMES if word != "passed" for check in by_outcome[word]]
    own_tables = [_own_table(check) for check in results if check.get("table")]
    values = {
        "tally": tally(results),
        "unmet": _table(unmet_checks),
        "passed": _table(by_outcome["passed"]),
        "passed_count": len(by_outcome["passed"]),
        "own": own_tables,
    }
    return rendered("checks", **values) if results else ""


def tally(results: Sequence[Mapping[str, Any]], noun: str = "") -> str:
    """Returns how many checks passed, failed and warn, as a text. `noun`: what is counted, with a space in
    front, such as " checks"."""
    words = [outcome(check) for check in results]
    passed = f"{words.count('passed')} of {len(results)}{noun} passed"
    warn = words.count("warning")
    other_counts = [f"{words.count('failed')} failed"] if "failed" in words else []
    other_counts += [f"{warn} {'warns' if warn == 1 else 'warn'}"] if warn else []
    return ", ".join([passed, *other_counts])


def outcome(check: Mapping[str, Any]) -> str:
    """Returns the outcome of a check: one of `OUTCOMES`."""
    if check["passed"]:
        return "passed"
    return "failed" if check["level"] == "error" else "warning"


def split_name(check: Mapping[str, Any]) -> tuple[str, str]:
    """Returns the file that a check is about ("" for none), and its title."""
    file, _, title = check["name"].rpartition(": ")
    return file, title


def _own_table(check: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the table that a check has besides its findings."""
    rows = check["table"]["rows"]
    summary = f"{split_name(check)[1]}: {check['detail']}".removeprefix(": ")
    page_table = plain_table(check["table"]["header"], rows)
    return {"summary": summary, "table": page_table, "brief": len(rows) > MAX_PRINTED_ROWS}


def finding_text(finding: Mapping[str, Any]) -> str:
    """Returns a finding as text: its element, attribute and message."""
    return f"{finding['element']} {finding['attribute']}".strip() + f": {finding['message']}"


def _table(checks_of_table: Sequence[Mapping[str, Any]]) -> PageTable | None:
    """Returns a table with a row for each check; files with exactly the same result share a row."""
    files: dict[tuple[Any, ...], list[str]] = {}
    for check in checks_of_table:
        file, title = split_name(check)
        results = stacked([check["detail"], *map(finding_text, check["findings"])])
        row_key = (outcome(check), check["code"], title, results, check["value"], check["limit"])
        files.setdefault(row_key, []).append(file)
    rows = []
    for (word, code, title, results, *figures), row_files in files.items():
        name = title if word == "passed" else to_code(code, title)
        rows.append([marked(word, _MARKS[word]), name, ", ".join(filter(None, row_files)), results, *figures])
    header = ["", "check", "file", "result", "value", "limit"]
    return table(header, rows, {"": "word", "value": "number", "limit": "number"}, heads="check")
