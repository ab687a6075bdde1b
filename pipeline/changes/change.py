"""Describes a difference between two robots."""

from dataclasses import dataclass
from typing import Any, Literal

Kind = Literal["added", "removed", "renamed", "changed"]


@dataclass(frozen=True, slots=True)
class Change:
    """A difference between the rows of two robots."""

    section: str
    """The table of robot.json with the row, such as "links"; or "robot"."""
    name: str
    """The row's name in the second robot, or in the first robot if the row was removed."""
    kind: Kind
    field: str = ""
    """The field that differs, with dots between levels; "" if the whole row was added or removed."""
    before: Any = None
    """The value in the first robot.json."""
    after: Any = None
    """The value in the second robot.json."""
    text: str = ""
    """Both values for people, with units."""
