"""Shows the differences of two robots as text, as a JSON document, and as Markdown for a pull request."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import groupby
from typing import Any

from linkwright.pipeline.changes.change import Change
from linkwright.pipeline.changes.read import ROBOT_FILE, SavedRobot
from linkwright.pipeline.json_documents.diff import ChangeDocument, ComparedRobot, DiffDocument
from linkwright.pipeline.reference.exit_status import BUILT, UNMET
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import printable

_ESCAPES = str.maketrans({mark: f"\\{mark}" for mark in "\\|`*_[]"} | {"<": "&lt;", ">": "&gt;"})
"""Character that Markdown or HTML would interpret → its escape in a cell of a Markdown table."""

FOLDER_NOTE = (
    f"only {ROBOT_FILE} of a folder is compared; "
    f"`linkwright check` compares its other files with {ROBOT_FILE}"
)
"""Note that is shown if a folder is compared."""


def as_text(before: SavedRobot, after: SavedRobot, changes: Sequence[Change]) -> str:
    """Returns a text with a line for each difference, grouped by table of robot.json and by row."""
    lines = [
        f"{_place_and_size(before)} → {_place_and_size(after)}",
        *source_changes(before.robot, after.robot),
    ]
    if before.is_folder or after.is_folder:
        lines.append(FOLDER_NOTE)
    if not changes:
        return "\n".join([*lines, "the same robot"])
    for table, table_changes in groupby(changes, lambda change: change.section):
        lines.append(_table_title(table))
        for name, row_changes in groupby(table_changes, lambda change: change.name):
            # Differences of the robot as a whole are in the table "robot", which has no rows.
            label = "" if table == "robot" else f"{printable(name)}: "
            for index, change in enumerate(row_changes):
                # The first line of a row has its label; the others are indented as far.
                prefix = label if index == 0 else " " * len(label)
                lines.append(f"  {prefix}{describe_change(change)}")
    return "\n".join([*lines, count(len(changes), "difference")])


def as_document(before: SavedRobot, after: SavedRobot, changes: Sequence[Change]) -> DiffDocument:
    """Returns the JSON document of the differences, with values as in robot.json."""
    change_documents = tuple(ChangeDocument(**asdict(change)) for change in changes)
    return DiffDocument(
        UNMET if changes else BUILT,
        _compared_robot(before),
        _compared_robot(after),
        alike=not changes,
        changes=change_documents,
    )


def as_markdown(before: SavedRobot, after: SavedRobot, changes: Sequence[Change]) -> str:
    """Returns Markdown that has a table for each table of robot.json with differences."""
    lines = [f"**{_cell(_place_and_size(before))} → {_cell(_place_and_size(after))}**", ""]
    lines += [f"{_cell(line)}\n" for line in source_changes(before.robot, after.robot)]
    if not changes:
        return "\n".join([*lines, "The same robot."])
    lines += [f"{count(len(changes), 'difference')}.", ""]
    for table, table_changes in groupby(changes, lambda change: change.section):
        lines += [f"| {_table_title(table)} | |", "|---|---|"]
        for change in table_changes:
            lines.append(f"| {_cell(change.name)} | {_cell(describe_change(change))} |")
        lines.append("")
    return "\n".join(lines).rstrip()


def _place_and_size(saved: SavedRobot) -> str:
    """Returns a text with the place of a robot, its name, its numbers of links and joints, and its mass."""
    document = saved.robot
    links, joints = count(len(document["links"]), "link"), count(len(document["joints"]), "joint")
    mass = f"{document.get('total_mass', 0):.6g} kg"
    return printable(f"{saved.place} ({document['name']}: {links}, {joints}, {mass})")


def _compared_robot(saved: SavedRobot) -> ComparedRobot:
    return ComparedRobot(saved.place, saved.robot["name"], saved.robot.get("source"))


def source_changes(before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[str]:
    """Yields a line for each difference between the sources of two robots, which may be equal otherwise.

    `before`, `after`: the content of their robot.json.
    """
    old, new = before.get("source") or {}, after.get("source") or {}
    for key in dict.fromkeys((*old, *new)):
        if old.get(key) != new.get(key):
            yield f"{key} of the source: {printable(str(old.get(key)))} → {printable(str(new.get(key)))}"


def _table_title(table: str) -> str:
    return table.replace("_", " ")


def describe_change(change: Change) -> str:
    """Returns the text of a difference, without the name of its row."""
    text = printable(change.text)
    if change.kind in ("added", "removed"):
        return f"{change.kind} ({text})" if text else change.kind
    return text


def _cell(text: str) -> str:
    """Returns a text, escaped for a cell of a Markdown table."""
    return printable(text).translate(_ESCAPES)
