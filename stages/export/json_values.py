"""Numbers, values and poses as robot.json has them."""

from typing import Any

import numpy as np

from stages.formats.numbers import number, numbers
from stages.robot.model import Array, Value
from stages.robot.poses import quat_from_rotation


def as_float(value: float | None, scale: float | None = None) -> float | None:
    return None if value is None else float(number(value, scale))


def as_floats(values: Array, scale: float | None = None) -> Any:
    """Nested lists of the array's shape, each number as short as the formatter makes it."""
    return np.array([float(text) for text in numbers(values, scale)]).reshape(np.shape(values)).tolist()


def as_value(value: Value) -> Any:
    """A dof's value: a number, or a list of them."""
    array = np.array(value)
    return as_floats(array, max(1.0, float(np.abs(array).max())))


def as_pose(pose: Array) -> dict[str, Any]:
    return {"xyz": as_floats(pose[:3, 3]), "quat": as_floats(quat_from_rotation(pose[:3, :3]))}


def short(value: float | None) -> float | None:
    """To six digits: what is computed from many poses differs in the last ones between machines."""
    return None if value is None else float(f"{value:.6g}") + 0.0
