"""Numbers, values and poses as robot.json has them."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from stages.formats.numbers import LENGTH, TURN, number, numbers
from stages.robot.model import Array, Value
from stages.robot.poses import quat_from_rotation


def as_float(value: float | None, least: float = 0.0) -> float | None:
    return None if value is None else float(number(value, least=least))


def as_floats(values: Iterable[float], least: float = 0.0) -> Any:
    """Nested lists of the array's shape, each number as short as the formatter makes it."""
    array = np.asarray(values, dtype=float)
    return np.array([float(text) for text in numbers(array, least=least)]).reshape(array.shape).tolist()


def as_value(value: Value) -> Any:
    """A dof's value: a number, or a list of them."""
    return as_floats(np.array(value), TURN)


def as_pose(pose: Array) -> dict[str, Any]:
    return {"xyz": as_floats(pose[:3, 3], LENGTH), "quat": as_floats(quat_from_rotation(pose[:3, :3]))}


def short(value: float | None) -> float | None:
    """To six digits: what is computed from many poses differs in the last ones between machines; below 1e-9
    all of them do."""
    if value is None:
        return None
    return float(f"{value:.6g}") if abs(value) > 1e-9 else 0.0
