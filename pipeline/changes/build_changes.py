"""Compares a build with the previous build in the same folder."""

import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from linkwright.pipeline.changes.change import Change
from linkwright.pipeline.changes.compare import compare
from linkwright.pipeline.changes.read import ROBOT_FILE, in_new_keys
from linkwright.pipeline.changes.show import describe_change, source_changes
from linkwright.pipeline.output import manifest
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.text.plural import count

MAX_ROBOT_CHANGES = 20
"""Largest number of differences of the robot that are described."""

REPORT = "report.json"

MAX_NAMES = 8
"""Largest number of changed files, and of changed checks, that are named."""


@dataclass(frozen=True, slots=True)
class BuildChanges:
    """The differences from the previous build in the folder."""

    first: bool = False
    """Whether there was no previous build."""
    robot: tuple[tuple[str, str], ...] = ()
    """Differences of the robot: table row and sentence."""
    more: int = 0
    """The number of further differences of the robot, which `robot` leaves out."""
    failure: str = ""
    """The reason why the robots could not be compared, or ""."""
    files: tuple[str, ...] = ()
    """Sentences on checks and files that changed."""

    @property
    def unchanged(self) -> bool:
        """Tells whether the folder holds a previous build with the same robot files."""
        return not (self.first or self.robot or self.failure or self.files)


def compare_builds(
    folder: Path,
    outputs: Mapping[str, str],
    files: Mapping[str, bytes],
    other_files: Collection[str] = (),
    checks: Iterable[Check] = (),
) -> BuildChanges:
    """Compares the build in `folder` with a new build, whose `files` are not written yet. `outputs`: path →
    SHA-256; `checks`: the new results; `other_files`: paths of the new build that are not outputs. Files with
    equal digests are not read."""
    before = manifest.written_files(folder)
    if before is None or not manifest.is_folder(folder):
        return BuildChanges(first=True)
    no_outputs = {*manifest.DOCUMENTS, *other_files}
    previous = {path: digest for path, digest in before.items() if path not in no_outputs}
    if previous == dict(outputs):
        return BuildChanges()
    sentences = (*_check_sentences(folder, tuple(checks)), *_file_sentences(previous, outputs))
    # Without both robot.json files, only the lists of files can be compared.
    if (
        ROBOT_FILE not in previous
        or ROBOT_FILE not in files
        or previous[ROBOT_FILE] == outputs.get(ROBOT_FILE)
    ):
        return BuildChanges(files=sentences)
    try:
        earlier = in_new_keys(json.loads((folder / ROBOT_FILE).read_bytes()))
        changes = _robot_changes(earlier, json.loads(files[ROBOT_FILE]))
    except Exception as error:  # an older build, or a changed file, may hold anything
        failure = f"the {ROBOT_FILE} of the previous build cannot be compared: {type(error).__name__}"
        return BuildChanges(failure=failure, files=sentences)
    return BuildChanges(
        robot=changes[:MAX_ROBOT_CHANGES], more=max(0, len(changes) - MAX_ROBOT_CHANGES), files=sentences
    )


def _robot_changes(before: Mapping[str, Any], after: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Returns the differences of two robots, each with the name of its row."""
    rows = [("source", line) for line in source_changes(before, after)]
    rows += [(_row_name(change), describe_change(change)) for change in compare(before, after)]
    return tuple(rows)


def _row_name(change: Change) -> str:
    """Names the row that changed, with its table: "link arm"."""
    if change.section == "robot":
        return "robot"
    return f"{change.section.removesuffix('s').replace('_', ' ')} {change.name}"


def _check_sentences(folder: Path, checks: Sequence[Check]) -> Iterator[str]:
    """Yields sentences on the checks that no longer pass, and on those that pass again."""
    try:
        rows = json.loads((folder / REPORT).read_bytes())["checks"]
        before = {row["name"]: row["passed"] for row in rows}
    except (OSError, ValueError, KeyError, TypeError):
        return
    groups = {
        "no longer passed": [
            check.name for check in checks if before.get(check.name) is True and not check.passed
        ],
        "passed again": [check.name for check in checks if before.get(check.name) is False and check.passed],
    }
    for word, names in groups.items():
        if names:
            more = f" and {len(names) - MAX_NAMES} more" if len(names) > MAX_NAMES else ""
            yield f"{word}: {', '.join(names[:MAX_NAMES])}{more}"


def _file_sentences(before: Mapping[str, str | None], after: Mapping[str, str]) -> Iterator[str]:
    """Yields sentences that name the files that are new, gone or different."""
    groups = {
        "new": [path for path in after if path not in before],
        "gone": [path for path in before if path not in after],
        "other content": [path for path in after if path in before and before[path] != after[path]],
    }
    for word, paths in groups.items():
        if paths:
            yield f"{word}: {_file_names(paths)}"


def _file_names(paths: Sequence[str]) -> str:
    """Lists files of the build's folder by name, and counts those in its subfolders."""
    top_files = sorted(path for path in paths if "/" not in path)
    inner_count = len(paths) - len(top_files)
    top_names = top_files[:MAX_NAMES]
    rest = [count(len(top_files) - len(top_names), "other file")] if len(top_files) > len(top_names) else []
    return ", ".join(
        [*top_names, *rest, *([f"{count(inner_count, 'file')} in folders"] if inner_count else [])]
    )
