"""Reads fields of the API's replies; a ProtocolError names the place of an invalid field."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.robot import Array


@contextmanager
def protocol_errors(subject: str, where: str) -> Iterator[None]:
    """Raises a ProtocolError that names the place `where` for errors that an unexpected format causes.
    `subject`: the part of a reply that is read."""
    try:
        yield
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        msg = f"the {subject} has an unknown format ({type(error).__name__}: {error})"
        hint = "fetch it again, or make the bundle again; if the error remains, the API has changed"
        raise ProtocolError(msg, where, hint) from error


def numbers(values: Any, count: int) -> Array:
    """Converts a list of `count` finite numbers to an array (count,); raises ValueError or TypeError."""
    if not isinstance(values, list) or len(values) != count:
        msg = f"expected {count} numbers, got {values!r:.80}"
        raise ValueError(msg)
    return np.array([number(value) for value in values])


def number(value: Any) -> float:
    """Returns the value as a float; raises ValueError or TypeError unless it is a finite number."""
    if isinstance(value, bool) or not math.isfinite(value):
        msg = f"expected a finite number, got {value!r:.80}"
        raise ValueError(msg)
    return float(value)


def text(value: Any) -> str:
    """Returns the value; raises TypeError unless it is a string that is not empty."""
    if not isinstance(value, str) or not value:
        msg = f"expected a name, got {value!r:.80}"
        raise TypeError(msg)
    return value


def id_path(ids: Any) -> tuple[str, ...]:
    """Converts a list of ids to a tuple; None becomes an empty tuple."""
    return tuple(text(element_id) for element_id in ids or ())


def check_rigid(transform: Array) -> None:
    """Raises ValueError unless a transform (4, 4) is rigid; a reflection is accepted."""
    rotation = transform[:3, :3]
    bottom_row_error = transform[3] - [0.0, 0.0, 0.0, 1.0]
    if not abs(rotation @ rotation.T - np.eye(3)).max() < 1e-6 or abs(bottom_row_error).max() > 1e-9:
        msg = "its axes are not orthonormal"
        raise ValueError(msg)
