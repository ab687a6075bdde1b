"""Finds the differences between a file and what a build writes in its place."""

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
"""Ending of a file's name → reader. Other files are compared byte by byte."""

MAX_LENGTH_RATIO, MAX_MORE_BYTES = 20, 1_000_000
"""A file that is longer than this ratio times a build's file plus this number of bytes is not read."""

_EXISTENCE_KEYS = ("", "{}")
"""Last entries of paths of facts that only state that something exists."""

_NOT_A_COPY = "differs from the file that it is a copy of"

Change = Literal["missing", "added", "other"]


@dataclass(frozen=True, slots=True)
class Difference:
    """A fact that differs from a build's."""

    change: Change
    path: tuple[str, ...]
    """The path of the fact's place."""

    finding: Finding


def differences(name: str, data: bytes, expected: bytes) -> Iterator[Difference]:
    """Yields the differences of a file of this name; nothing if both contents have the same facts."""
    if data == expected:
        return
    reader = READERS.get(PurePosixPath(name).suffix or name)
    try:
        facts = dict(reader(expected)) if reader is not None else None
    except Unparsable:
        facts = None
    if reader is None or facts is None:
        yield _difference_of_file(_NOT_A_COPY)
    elif len(data) > MAX_LENGTH_RATIO * len(expected) + MAX_MORE_BYTES:
        yield _difference_of_file(f"has {len(data)} bytes, expected {len(expected)}")
    else:
        try:
            yield from _differences(dict(reader(data)), facts)
        except Unparsable as error:
            yield _difference_of_file(str(error))
        except RecursionError:
            yield _difference_of_file("is nested too deep")


def _difference_of_file(message: str) -> Difference:
    return Difference("other", (), Finding("file", "", message))


def _differences(facts: Facts, expected_facts: Facts) -> Iterator[Difference]:
    places = {place.path: place for place in (*facts, *expected_facts)}
    values = {place.path: value for place, value in facts.items()}
    expected = {place.path: value for place, value in expected_facts.items()}
    reported: set[tuple[str, ...]] = set()
    for path in sorted(places):
        # The content of a missing element is missing too.
        if any(path[:length] in reported for length in range(1, len(path))):
            continue
        place = places[path]
        if path in values and path in expected:
            if not same(values[path], expected[path], place.least):
                yield _difference("other", place, _difference_text(values[path], expected[path]))
            continue
        reported.add(path[:-1] if path[-1] in _EXISTENCE_KEYS else path)
        if path in expected:
            wish = "" if expected[path] is True else f", expected {shown(expected[path])}"
            yield _difference("missing", place, f"is missing{wish}")
        else:
            word = "there" if values[path] is True else shown(values[path])
            yield _difference("added", place, f"is {word}, but a build does not write it")


def _difference_text(value: Value, expected: Value) -> str:
    """Returns a text on the difference of two values; for long rows only on the entries that differ."""
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
