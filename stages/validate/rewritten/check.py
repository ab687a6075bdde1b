"""The checks of files that are written from others: each says what a build would write again."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path, PurePosixPath

from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.robot.model.amendments import Amendment
from linkwright.stages.robot.system.regular_files import is_file
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import few, named
from linkwright.stages.validate.reading.documents import sentence
from linkwright.stages.validate.rewritten.amended import is_amended
from linkwright.stages.validate.rewritten.compare import Difference, differences
from linkwright.stages.validate.rewritten.own import DESCRIBES, Weight, weight_of

MANY = (".stl", ".obj", ".mtl", ".png", ".usd")
"""Endings of files of which a folder has many: their check is one."""


def rewritten(
    folder: Path,
    expected: Mapping[str, bytes],
    *,
    copies: bool,
    current: bool,
    changes: Sequence[Amendment] = (),
) -> Iterator[Check]:
    """Whether each file, by its path, says what is expected. `copies`: whether they are copies, in which the
    user sets nothing; `current`: whether this version of Linkwright wrote them: another version writes other
    texts, so a difference is no fault; `changes`: what the user's own XML changed in files that describe the
    robot."""
    levels: tuple[CheckLevel, CheckLevel] = ("warning", "error" if current else "warning")
    many = [path for path in sorted(expected) if PurePosixPath(path).suffix in MANY]
    for path in sorted(expected.keys() - {*many}):
        every = [
            (difference, weight)
            for difference, weight in _differences(folder, path, expected[path], copies)
            if not path.endswith(DESCRIBES) or not is_amended(difference, changes)
        ]
        wrong = [difference.finding for difference, weight in every if weight == "error"]
        found = (*wrong, *(difference.finding for difference, weight in every if weight == "warning"))
        yield _check(f"{path}: text", found, levels[bool(wrong)], "says what a build writes")
    for place, paths in groupby(many, lambda path: str(PurePosixPath(path).parent)):
        files = [*paths]
        found = tuple(
            replace(difference.finding, element=named("file", PurePosixPath(path).name))
            for path in files
            for difference, _ in _differences(folder, path, expected[path], copies=True)
        )
        detail = f"{count(len(files), 'file')} as those of which they are copies"
        yield _check(f"{place}: copies", found, levels[1], detail)


def _check(name: str, found: tuple[Finding, ...], level: CheckLevel, passed: str) -> Check:
    detail = sentence(found) if found else passed
    return Check(name, not found, detail, float(len(found)), 0.0, "", level, few(found))


def _differences(
    folder: Path, path: str, expected: bytes, copies: bool
) -> Iterator[tuple[Difference, Weight]]:
    """What differs, and counts."""
    if not is_file(folder / path):
        yield Difference("missing", (), Finding("file", "", "there is none")), "error"
        return
    name = PurePosixPath(path).name
    for difference in differences(name, (folder / path).read_bytes(), expected):
        weight: Weight = "error" if copies else weight_of(name, difference)
        if weight:
            yield difference, weight
