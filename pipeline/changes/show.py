"""Shows the differences of two robots as text, as JSON, and as Markdown for a pull request."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import groupby
from typing import Any

from linkwright.pipeline.changes.change import Change
from linkwright.pipeline.changes.read import FILE, Described
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import printable

FOLDER_NOTE = (
    f"of a folder only its {FILE} is compared; `linkwright check` compares the other files with that"
)
"""Note that is shown if a folder is compared."""


def as_text(before: Described, after: Described, changes: Sequence[Change]) -> str:
    """Returns a text with a line for each difference, grouped by table and row."""
    lines = [
        f"{_place_and_size(before)} → {_place_and_size(after)}",
        *moved_source(before.robot, after.robot),
    ]
    if before.folder or after.folder:
        lines.append(FOLDER_NOTE)
    if not changes:
        return "\n".join([*lines, "the same robot"])
    for section, in_section in groupby(changes, lambda change: change.section):
        lines.append(_title(section))
        for name, in_row in groupby(in_section, lambda change: change.name):
            label = "" if section == "robot" else f"{printable(name)}: "
            indent = "  " + label
            for change in in_row:
                lines.append(indent + sentence(change))
                indent = "  " + " " * len(label)
    return "\n".join([*lines, count(len(changes), "difference")])


def as_json(before: Described, after: Described, changes: Sequence[Change]) -> str:
    """Returns the differences as JSON, with the values of robot.json."""
    table = {
        "format": "linkwright-diff",
        "version": 1,
        "before": _place(before),
        "after": _place(after),
        "alike": not changes,
        "changes": [asdict(change) for change in changes],
    }
    return json.dumps(table, indent=2, ensure_ascii=False)


def as_markdown(before: Described, after: Described, changes: Sequence[Change]) -> str:
    """Returns Markdown with a table for each table of robot.json that differs."""
    lines = [f"**{_cell(_place_and_size(before))} → {_cell(_place_and_size(after))}**", ""]
    lines += [f"{_cell(line)}\n" for line in moved_source(before.robot, after.robot)]
    if not changes:
        return "\n".join([*lines, "The same robot."])
    lines += [f"{count(len(changes), 'difference')}.", ""]
    for section, in_section in groupby(changes, lambda change: change.section):
        lines += [f"| {_title(section)} | |", "|---|---|"]
        lines += [f"| {_cell(change.name)} | {_cell(sentence(change))} |" for change in in_section]
        lines.append("")
    return "\n".join(lines).rstrip()


def _place_and_size(described: Described) -> str:
    """Returns the place of a robot, and its size."""
    robot = described.robot
    links, joints = (count(len(robot[key]), key[:-1]) for key in ("links", "joints"))
    mass = f"{robot.get('total_mass', 0):.6g} kg"
    return printable(f"{described.place} ({robot['name']}: {links}, {joints}, {mass})")


def _place(described: Described) -> dict[str, Any]:
    return {
        "place": described.place,
        "name": described.robot["name"],
        "source": described.robot.get("source"),
    }


def moved_source(robot: Mapping[str, Any], later: Mapping[str, Any]) -> Iterator[str]:
    """Yields differences of the robots' sources; the robots themselves may be the same."""
    before, after = robot.get("source") or {}, later.get("source") or {}
    for key in dict.fromkeys((*before, *after)):
        if before.get(key) != after.get(key):
            yield f"{key} of the source: {printable(str(before.get(key)))} → {printable(str(after.get(key)))}"


def _title(section: str) -> str:
    return section.replace("_", " ")


def sentence(change: Change) -> str:
    """Returns a difference in words, without its row."""
    text = printable(change.text)
    if change.kind in ("added", "removed"):
        return f"{change.kind} ({text})" if text else change.kind
    return text


def _cell(text: str) -> str:
    """Escapes a text for a cell of a Markdown table."""
    escaped = printable(text).replace("\\", "\\\\")
    for mark in "|`*_[]<>":
        escaped = escaped.replace(mark, f"\\{mark}" if mark not in "<>" else {"<": "&lt;", ">": "&gt;"}[mark])
    return escaped
