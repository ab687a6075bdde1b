"""A table of robot.json: its fields by type, and where each is for the error that names it."""

import sys
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from stages.robot.model import Array, frozen
from stages.robot.poses import UNMOVED, from_parts, rotation_from_quat


class RobotJsonError(Exception):
    """robot.json does not say what it must. The message names the field."""


class Fields:
    """A mapping of robot.json; `place`: where it is, as in `joints[2].dofs[0]`."""

    def __init__(self, table: Any, place: str = "") -> None:
        self.place = place
        if not isinstance(table, Mapping):
            raise self._not("", "a table", table)
        self.table = table

    def has(self, key: str) -> bool:
        """Whether the field is there, and not null."""
        return self.table.get(key) is not None

    def text(self, key: str) -> str:
        return str(self._of(key, str, "a text"))

    def truth(self, key: str) -> bool:
        return bool(self._of(key, bool, "true or false"))

    def whole(self, key: str) -> int:
        return int(self._of(key, int, "a whole number"))

    def number(self, key: str) -> float:
        """A finite number."""
        return _finite(self._of(key, int | float, "a number"), self, key)

    def number_or_none(self, key: str) -> float | None:
        """None for null."""
        return self.number(key) if self.has(key) else None

    def numbers(self, key: str, *counts: int) -> tuple[float, ...]:
        """A list of numbers, as many as one of `counts`; of any length without."""
        found = self._of(key, list, "a list of numbers")
        if counts and len(found) not in counts:
            raise self._not(key, f"{' or '.join(map(str, counts))} numbers", found)
        return tuple(_finite(one, self, key) for one in found)

    def ends(self, key: str) -> tuple[float | None, float | None]:
        """Two numbers, each of which may be null."""
        found = self._of(key, list, "two ends")
        if len(found) != 2:
            raise self._not(key, "two ends", found)
        low, high = (None if one is None else _finite(one, self, key) for one in found)
        return low, high

    def value(self, key: str) -> float | tuple[float, ...]:
        """A dof's value: a number, or those of a ball (4) or of free motion (7)."""
        if isinstance(self.table.get(key), list):
            return self.numbers(key, 4, 7)
        return self.number(key)

    def texts(self, key: str) -> tuple[str, ...]:
        found = self._of(key, list, "a list of texts")
        if not all(isinstance(one, str) for one in found):
            raise self._not(key, "a list of texts", found)
        return tuple(found)

    def vector(self, key: str) -> Array:
        """Three numbers (3,)."""
        return frozen(self.numbers(key, 3))

    def tensor(self, key: str) -> Array:
        """Three times three numbers (3, 3)."""
        rows = self._of(key, list, "a 3x3 tensor")
        flat = [one for row in rows if isinstance(row, list) and len(row) == 3 for one in row]
        if len(rows) != 3 or len(flat) != 9:
            raise self._not(key, "a 3x3 tensor", rows)
        return frozen(np.reshape([_finite(one, self, key) for one in flat], (3, 3)))

    def pose(self, key: str) -> Array:
        """{xyz, quat} as a transform (4, 4)."""
        record = self.inside(key)
        quat = np.array(record.numbers("quat", 4))
        if not np.linalg.norm(quat) > 0.0:
            raise record._not("quat", "a quaternion", quat.tolist())
        return frozen(from_parts(rotation_from_quat(quat), np.array(record.numbers("xyz", 3))))

    def pose_or_none(self, key: str) -> Array:
        """As `pose`; that of what has not moved for null."""
        return self.pose(key) if self.has(key) else UNMOVED

    def inside(self, key: str) -> "Fields":
        return Fields(self._of(key, Mapping, "a table"), self._place(key))

    def pairs(self, key: str) -> tuple[tuple[float, float], ...]:
        """A list of pairs of numbers; none where it is not there."""
        rows = self._of(key, list, "a list of pairs") if self.has(key) else []
        both = [Fields({key: row}, self.place).numbers(key, 2) for row in rows]
        return tuple((first, second) for first, second in both)

    def records(self, key: str) -> "list[Fields]":
        """The rows of a table; none where it is not there."""
        if key not in self.table:
            return []
        rows = self._of(key, list, "a list")
        return [Fields(row, f"{self._place(key)}[{index}]") for index, row in enumerate(rows)]

    def items(self, key: str) -> Iterator[tuple[str, Any]]:
        """The pairs of a mapping; none where it is not there."""
        if self.has(key):
            yield from self._of(key, Mapping, "a table").items()

    def one_of(self, key: str, *words: str) -> Any:
        """A text that is one of these."""
        found = self.text(key)
        if found not in words:
            raise self._not(key, f"one of {', '.join(words)}", found)
        return found

    def _of(self, key: str, kind: Any, expected: str) -> Any:
        found = self.table.get(key)
        if not isinstance(found, kind) or (isinstance(found, bool) and kind is not bool):
            raise self._not(key, expected, found)
        return found

    def _place(self, key: str) -> str:
        return f"{self.place}.{key}".strip(".")

    def _not(self, key: str, expected: str, found: Any) -> RobotJsonError:
        shown = "nothing" if found is None else repr(found)
        shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
        return RobotJsonError(f"{self._place(key) or 'the file'}: expected {expected}, found {shown}")


def _finite(found: Any, record: Fields, key: str) -> float:
    # A whole number may be too large for any other.
    if isinstance(found, bool) or not isinstance(found, int | float) or not abs(found) <= sys.float_info.max:
        raise record._not(key, "finite numbers", found)
    return float(found)
