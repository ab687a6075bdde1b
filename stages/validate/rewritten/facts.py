"""Defines facts, which are the content of a file: a value at each place. The order of places, white space,
comments, quotes and the digits of a number are not facts."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from linkwright.stages.robot.model.poses import rotation_from_rpy

TOLERANCE = 1e-9
"""Tolerance of numbers, relative to the largest number of their row, and of turns [rad]."""


class Unparsable(Exception):
    """The text is not of its format. The message says why."""


@dataclass(frozen=True, slots=True)
class Turn:
    """A rotation by three angles [rad]. It is compared as a rotation, since near 90 degrees other angles give
    the same."""

    rpy: tuple[float, float, float]


Value: TypeAlias = "str | int | float | bool | Turn | tuple[Value, ...] | None"
"""A text, a number, or a row of these. In YAML 3 differs from 3.0, since ROS does not accept 3 as a real
number."""


@dataclass(frozen=True, slots=True)
class Place:
    """The place of a fact in a file."""

    path: tuple[str, ...]
    """A path that is unique in the file."""

    element: str
    """The element, as it is shown to a reader."""

    attribute: str
    """The attribute, as it is shown to a reader."""

    least: float = 0.0
    """Smallest value to which differences of numbers are relative."""


Facts = Mapping[Place, Value]

Reader = Callable[[bytes], Iterator[tuple[Place, Value]]]
"""Reads the facts of a file. Raises Unparsable if its text is not of its format."""


def same(value: Value, expected: Value, least: float = 0.0) -> bool:
    """Tells whether two values are the same, apart from the white space of texts, and from rounding.
    `least`: as in `Place`."""
    if isinstance(value, Turn) and isinstance(expected, Turn):
        offset = rotation_from_rpy(value.rpy) - rotation_from_rpy(expected.rpy)
        return bool(abs(offset).max() <= TOLERANCE)
    if isinstance(value, tuple) and isinstance(expected, tuple):
        if len(value) != len(expected):
            return False
        numbers = [abs(entry) for entry in expected if isinstance(entry, float)]
        scale = max((least, *filter(math.isfinite, numbers)))
        return all(same(*pair, scale) for pair in zip(value, expected, strict=True))
    if isinstance(value, float) and isinstance(expected, float):
        tolerance = TOLERANCE * max(least, abs(expected))
        # The tolerance of an infinite number would be infinite.
        return value == expected or (math.isfinite(expected) and abs(value - expected) <= tolerance)
    if isinstance(value, str) and isinstance(expected, str):
        return value.split() == expected.split()
    return type(value) is type(expected) and value == expected


def words(text: str) -> Value:
    """Returns a text as a fact, which is a row of numbers if it has only numbers."""
    try:
        numbers = tuple(float(word) for word in text.split())
    except ValueError:
        return text
    return numbers if numbers and all(map(math.isfinite, numbers)) else text


def shown(value: Value) -> str:
    """Returns a value as text for a message."""
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
    return text if len(text) <= MAX_LETTERS else f"{text[: MAX_LETTERS - 3]}..."


MAX_LETTERS = 80
"""Largest number of letters of a value in a message."""
