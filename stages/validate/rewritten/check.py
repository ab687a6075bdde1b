"""Checks the files that are written from others, by comparing each with what a build would write."""

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
from linkwright.stages.validate.rewritten.user_settings import ROBOT_ENDINGS, Weight, weight_of

GROUPED_ENDINGS = (".stl", ".obj", ".mtl", ".png", ".usd")
"""Endings of files that a folder has many of, so that they share a check."""


def rewritten(
    folder: Path,
    expected: Mapping[str, bytes],
    *,
    copies: bool,
    current: bool,
    changes: Sequence[Amendment] = (),
) -> Iterator[Check]:
    """Compares each file with its expected content, by path.

    `copies`: whether the files are copies, in which the user sets nothing. `current`: whether this version of
    Linkwright wrote the files: other versions write other texts, so that a difference is not a fault.
    `changes`: the changes by the user's own XML to files that describe the robot.
    """
    fault_level: CheckLevel = "error" if current else "warning"
    grouped = [path for path in expected if PurePosixPath(path).suffix in GROUPED_ENDINGS]
    for path in sorted(expected.keys() - {*grouped}):
        weighted_differences = [
            (difference, weight)
            for difference, weight in _differences(folder, path, expected[path], copies)
            if not path.endswith(ROBOT_ENDINGS) or not is_amended(difference, changes)
        ]
        wrong = [difference.finding for difference, weight in weighted_differences if weight == "error"]
        findings = (
            *wrong,
            *(difference.finding for difference, weight in weighted_differences if weight == "warning"),
        )
        yield _check(
            f"{path}: text", findings, fault_level if wrong else "warning", "equals what a build writes"
        )
    # In the order of paths alone, a subfolder may be between the files of its folder.
    grouped.sort(key=lambda path: (_folder(path), path))
    for place, paths in groupby(grouped, _folder):
        files = [*paths]
        findings = tuple(
            replace(difference.finding, element=named("file", PurePosixPath(path).name))
            for path in files
            for difference, _ in _differences(folder, path, expected[path], copies=True)
        )
        detail = f"{count(len(files), 'file')} equal to the files that they are copies of"
        yield _check(f"{place}: copies", findings, fault_level, detail)


def _folder(path: str) -> str:
    return str(PurePosixPath(path).parent)


def _check(name: str, findings: tuple[Finding, ...], level: CheckLevel, passed: str) -> Check:
    detail = sentence(findings) if findings else passed
    return Check(name, not findings, detail, float(len(findings)), 0.0, "", level, few(findings))


def _differences(
    folder: Path, path: str, expected: bytes, copies: bool
) -> Iterator[tuple[Difference, Weight]]:
    """Yields the differences that count, with their weights."""
    if not is_file(folder / path):
        yield Difference("missing", (), Finding("file", "", "is missing")), "error"
        return
    name = PurePosixPath(path).name
    for difference in differences(name, (folder / path).read_bytes(), expected):
        weight: Weight = "error" if copies else weight_of(name, difference)
        if weight:
            yield difference, weight
