"""The differences between a file and what a build writes in its place."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Literal

from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.rewritten.facts import Facts, Place, Reader, Unparsable, Value, same, shown
from linkwright.stages.validate.rewritten.line_facts import cmake_facts, text_facts
from linkwright.stages.validate.rewritten.python_facts import python_facts
from linkwright.stages.validate.rewritten.tree_facts import json_facts, toml_facts, yaml_facts
from linkwright.stages.validate.rewritten.xml_facts import xml_facts

READERS: Mapping[str, Reader] = {
    **dict.fromkeys((".xml", ".urdf", ".srdf", ".sdf", ".xacro", ".config"), xml_facts),
    **dict.fromkeys((".yaml", ".rviz", ".setup_assistant"), yaml_facts),
    ".toml": toml_facts,
    ".json": json_facts,
    ".py": python_facts,
    ".txt": cmake_facts,
    **dict.fromkeys((".obj", ".mtl", ".usda"), text_facts),
}
"""What reads a file, by the ending of its name; any other is compared byte by byte."""

LONGER, MORE = 20, 1_000_000
"""A file that is as many times longer than what a build writes, and by as many bytes, is not read."""

_MARKS = ("", "{}")
"""Ends of the path of what only says that something is there."""

_OTHER_BYTES = "has other bytes than the file that it is a copy of"

Change = Literal["missing", "added", "other"]


@dataclass(frozen=True, slots=True)
class Difference:
    """A fact that a build does not write so: it is missing, added, or another. `path`: of its place."""

    change: Change
    path: tuple[str, ...]
    finding: Finding


def differences(name: str, data: bytes, expected: bytes) -> Iterator[Difference]:
    """Of a file of this name. None where both say the same."""
    if data == expected:
        return
    reader = READERS.get(PurePosixPath(name).suffix or name)
    try:
        wanted = dict(reader(expected)) if reader is not None else None
    except Unparsable:
        wanted = None
    if reader is None or wanted is None:
        yield _of_file(_OTHER_BYTES)
    elif len(data) > LONGER * len(expected) + MORE:
        yield _of_file(f"has {len(data)} bytes, expected {len(expected)}")
    else:
        try:
            yield from _differences(dict(reader(data)), wanted)
        except Unparsable as error:
            yield _of_file(str(error))
        except RecursionError:
            yield _of_file("is nested too deep")


def _of_file(message: str) -> Difference:
    return Difference("other", (), Finding("file", "", message))


def _differences(facts: Facts, wanted: Facts) -> Iterator[Difference]:
    places = {place.path: place for place in (*facts, *wanted)}
    values = {place.path: value for place, value in facts.items()}
    expected = {place.path: value for place, value in wanted.items()}
    reported: set[tuple[str, ...]] = set()
    for path in sorted(places):
        # What is in an element that is not there is not there either.
        if any(path[:length] in reported for length in range(1, len(path))):
            continue
        place = places[path]
        if path in values and path in expected:
            if not same(values[path], expected[path], place.least):
                yield _difference("other", place, _otherwise(values[path], expected[path]))
            continue
        reported.add(path[:-1] if path[-1] in _MARKS else path)
        if path in expected:
            wish = "" if expected[path] is True else f", expected {shown(expected[path])}"
            yield _difference("missing", place, f"there is none{wish}")
        else:
            word = "there" if values[path] is True else shown(values[path])
            yield _difference("added", place, f"is {word}, and a build writes none")


def _otherwise(value: Value, expected: Value) -> str:
    """How a value differs, of long rows only where."""
    if isinstance(value, tuple) and isinstance(expected, tuple):
        surplus, missing = (
            tuple(entry for entry in row if entry not in other)
            for row, other in ((value, expected), (expected, value))
        )
        if surplus != value and (surplus or missing):
            parts = (("has ", surplus), ("lacks ", missing))
            return " and ".join(word + shown(entries) for word, entries in parts if entries)
    return f"is {shown(value)}, expected {shown(expected)}"


def _difference(change: Change, place: Place, message: str) -> Difference:
    return Difference(change, place.path, Finding(place.element, place.attribute, message))
