"""What a file says, as facts: a value at each place. Order, white space, comments, quotes and the digits of a
number are not facts."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from linkwright.stages.robot.model.poses import rotation_from_rpy

SAME = 1e-9
"""Numbers are the same within this, relative to the largest of their row, and turns within this [rad]."""


class Unparsable(Exception):
    """The text is not of its format. The message says why."""


@dataclass(frozen=True, slots=True)
class Turn:
    """Three angles that stand for the rotation that they make: near 90 degrees others make the same."""

    rpy: tuple[float, float, float]


Value: TypeAlias = "str | int | float | bool | Turn | tuple[Value, ...] | None"
"""Texts and numbers, and rows of them. In YAML 3 is another value than 3.0: ROS does not take it for a real
number."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a fact is: `path` tells it from all others of the file; `element` and `attribute` name it for a
    reader. `least`: numbers there are compared relative to no less than this."""

    path: tuple[str, ...]
    element: str
    attribute: str
    least: float = 0.0


Facts = Mapping[Place, Value]

Reader = Callable[[bytes], Iterator[tuple[Place, Value]]]
"""Reads the facts of a file. Unparsable where its text is not of its format."""


def same(value: Value, expected: Value, least: float = 0.0) -> bool:
    """Whether two values are the same; texts are, whatever white space is in them. `least`: see `Place`."""
    if isinstance(value, Turn) and isinstance(expected, Turn):
        offset = rotation_from_rpy(value.rpy) - rotation_from_rpy(expected.rpy)
        return bool(abs(offset).max() <= SAME)
    if isinstance(value, tuple) and isinstance(expected, tuple):
        if len(value) != len(expected):
            return False
        numbers = [abs(entry) for entry in expected if isinstance(entry, float)]
        scale = max((least, *filter(math.isfinite, numbers)))
        return all(same(*pair, scale) for pair in zip(value, expected, strict=True))
    if isinstance(value, float) and isinstance(expected, float):
        return value == expected or abs(value - expected) <= SAME * max(least, abs(expected))
    if isinstance(value, str) and isinstance(expected, str):
        return value.split() == expected.split()
    return type(value) is type(expected) and value == expected


def words(text: str) -> Value:
    """A text as a fact: a row of numbers where it is nothing but that."""
    try:
        numbers = tuple(float(word) for word in text.split())
    except ValueError:
        return text
    return numbers if numbers and all(map(math.isfinite, numbers)) else text


def shown(value: Value) -> str:
    """A value in a message."""
    if isinstance(value, Turn):
        return shown(value.rpy)
    if isinstance(value, tuple):
        space = " " if all(isinstance(entry, float) for entry in value) else ", "
        text = space.join(map(shown, value))
    elif isinstance(value, float):
        text = f"{value:.12g}"
    elif isinstance(value, str):
        text = f'"{" ".join(value.split())}"'
    else:
        text = str(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


LONGEST = 80
"""Letters of a value in a message."""
