"""What a build changes about the robot that the last build left in the same folder."""

import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from linkwright.pipeline.changes.change import Change
from linkwright.pipeline.changes.read import FILE
from linkwright.pipeline.output import manifest
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.text.plural import count

MOST = 20
"""So many differences of the robot are said in words."""

REPORT = "report.json"

_MOST_FILES = 8
"""So many files and checks that differ are named."""


@dataclass(frozen=True, slots=True)
class Since:
    """What is different from the last build in the folder.

    `first`: no build was there. `robot`: differences of the robot, a thing and what is said of it each, and
    how many `more` there are; `unknown`: why these could not be found, or nothing; `files`: of its checks and
    files, each a sentence.
    """

    first: bool = False
    robot: tuple[tuple[str, str], ...] = ()
    more: int = 0
    unknown: str = ""
    files: tuple[str, ...] = ()

    @property
    def nothing(self) -> bool:
        """Whether every file of the robot is as it was."""
        return not (self.first or self.robot or self.unknown or self.files)


def since(
    folder: Path,
    outputs: Mapping[str, str],
    files: Mapping[str, bytes],
    beside: Collection[str] = (),
    checks: Iterable[Check] = (),
) -> Since:
    """The differences between the build in `folder` and one with the `outputs` (SHA-256 by path) and the
    `checks`, whose `files` are not written yet; `beside`: files of the new build that are no outputs. What is
    equal by its digest is not read."""
    before = manifest.ours(folder)
    if before is None or not manifest.is_folder(folder):
        return Since(first=True)
    others = {*manifest.DOCUMENTS, *beside}
    was = {path: digest for path, digest in before.items() if path not in others}
    if was == dict(outputs):
        return Since()
    told = (*_checks(folder, tuple(checks)), *_files(was, outputs))
    if FILE not in was or FILE not in files or was[FILE] == outputs.get(FILE):
        return Since(files=told)
    try:
        changes = _compared(json.loads((folder / FILE).read_bytes()), json.loads(files[FILE]))
    except Exception as error:  # an older build, or a changed file, may hold anything
        failed = f"the {FILE} of the previous build cannot be compared: {type(error).__name__}"
        return Since(unknown=failed, files=told)
    return Since(robot=changes[:MOST], more=max(0, len(changes) - MOST), files=told)


def _compared(before: Mapping[str, Any], after: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """The differences of two robots, a thing and what is said of it each."""
    # Late: a first build, and one without changes, compares nothing.
    from linkwright.pipeline.changes.compare import compare
    from linkwright.pipeline.changes.show import moved_source, sentence

    said = [("source", line) for line in moved_source(before, after)]
    said += [(_thing(change), sentence(change)) for change in compare(before, after)]
    return tuple(said)


def _thing(change: Change) -> str:
    """A thing with its table: "link arm"."""
    if change.section == "robot":
        return "robot"
    return f"{change.section.removesuffix('s').replace('_', ' ')} {change.name}"


def _checks(folder: Path, checks: Sequence[Check]) -> Iterator[str]:
    """Checks that no longer pass, and that pass again."""
    try:
        before = {one["name"]: one["passed"] for one in json.loads((folder / REPORT).read_bytes())["checks"]}
    except (OSError, ValueError, KeyError, TypeError):
        return
    groups = {
        "no longer passed": [one.name for one in checks if before.get(one.name) is True and not one.passed],
        "passed again": [one.name for one in checks if before.get(one.name) is False and one.passed],
    }
    for word, names in groups.items():
        if names:
            more = f" and {len(names) - _MOST_FILES} more" if len(names) > _MOST_FILES else ""
            yield f"{word}: {', '.join(names[:_MOST_FILES])}{more}"


def _files(before: Mapping[str, str | None], after: Mapping[str, str]) -> Iterator[str]:
    """Which files came, went and differ."""
    groups = {
        "new": [path for path in after if path not in before],
        "gone": [path for path in before if path not in after],
        "other content": [path for path in after if path in before and before[path] != after[path]],
    }
    for word, paths in groups.items():
        if paths:
            yield f"{word}: {_listed(paths)}"


def _listed(paths: Sequence[str]) -> str:
    """The files by name, those in a folder below counted."""
    top = sorted(path for path in paths if "/" not in path)
    inside = len(paths) - len(top)
    named = top[:_MOST_FILES]
    rest = [count(len(top) - len(named), "other file")] if len(top) > len(named) else []
    return ", ".join([*named, *rest, *([f"{count(inside, 'file')} in folders"] if inside else [])])
