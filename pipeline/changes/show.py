"""Differences of two robots as text, as JSON for programs, and as Markdown for a pull request."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import groupby
from typing import Any

from linkwright.pipeline.changes.change import Change
from linkwright.pipeline.changes.read import FILE, Described
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import printable

ONLY = f"of a folder only its {FILE} is compared; `linkwright check` compares the other files with that"
"""What is said where a folder was given."""


def as_text(one: Described, other: Described, changes: Sequence[Change]) -> str:
    """A line for each difference, under the thing that has it, under its table."""
    lines = [f"{_named(one)} → {_named(other)}", *moved_source(one.robot, other.robot)]
    if one.folder or other.folder:
        lines.append(ONLY)
    if not changes:
        return "\n".join([*lines, "the same robot"])
    for section, found in groupby(changes, lambda change: change.section):
        lines.append(_title(section))
        for name, same in groupby(found, lambda change: change.name):
            label = "" if section == "robot" else f"{printable(name)}: "
            indent = "  " + label
            for change in same:
                lines.append(indent + sentence(change))
                indent = "  " + " " * len(label)
    return "\n".join([*lines, count(len(changes), "difference")])


def as_json(one: Described, other: Described, changes: Sequence[Change]) -> str:
    """Differences with their values as robot.json has them."""
    table = {
        "format": "linkwright-diff",
        "version": 1,
        "before": _place(one),
        "after": _place(other),
        "alike": not changes,
        "changes": [asdict(change) for change in changes],
    }
    return json.dumps(table, indent=2, ensure_ascii=False)


def as_markdown(one: Described, other: Described, changes: Sequence[Change]) -> str:
    """A table for each table of robot.json."""
    lines = [f"**{_cell(_named(one))} → {_cell(_named(other))}**", ""]
    lines += [f"{_cell(line)}\n" for line in moved_source(one.robot, other.robot)]
    if not changes:
        return "\n".join([*lines, "The same robot."])
    lines += [f"{count(len(changes), 'difference')}.", ""]
    for section, found in groupby(changes, lambda change: change.section):
        lines += [f"| {_title(section)} | |", "|---|---|"]
        lines += [f"| {_cell(change.name)} | {_cell(sentence(change))} |" for change in found]
        lines.append("")
    return "\n".join(lines).rstrip()


def _named(one: Described) -> str:
    """Where a robot is, and its size."""
    robot = one.robot
    links, joints = (count(len(robot[key]), key[:-1]) for key in ("links", "joints"))
    return printable(f"{one.place} ({robot['name']}: {links}, {joints}, {robot.get('mass', 0):.6g} kg)")


def _place(one: Described) -> dict[str, Any]:
    return {"place": one.place, "name": one.robot["name"], "source": one.robot.get("source")}


def moved_source(one: Mapping[str, Any], other: Mapping[str, Any]) -> Iterator[str]:
    """What is different about where the robots come from, which alone is no difference of them."""
    before, after = one.get("source") or {}, other.get("source") or {}
    for key in dict.fromkeys((*before, *after)):
        if before.get(key) != after.get(key):
            yield f"{key} of the source: {printable(str(before.get(key)))} → {printable(str(after.get(key)))}"


def _title(section: str) -> str:
    return section.replace("_", " ")


def sentence(change: Change) -> str:
    """What is said of a difference of the thing that has it."""
    text = printable(change.text)
    if change.kind in ("added", "removed"):
        return f"{change.kind} ({text})" if text else change.kind
    return text


def _cell(text: str) -> str:
    """Text in a cell of a table of Markdown, whatever it holds."""
    kept = printable(text).replace("\\", "\\\\")
    for mark in "|`*_[]<>":
        kept = kept.replace(mark, f"\\{mark}" if mark not in "<>" else {"<": "&lt;", ">": "&gt;"}[mark])
    return kept
