"""Reads fields of the API's replies; ProtocolError names the place of an invalid field."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.robot import Array


@contextmanager
def shape_of(what: str, where: str) -> Iterator[None]:
    """Turns Python's errors about an unexpected form into a ProtocolError with its place."""
    try:
        yield
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        msg = f"the {what} has an unknown format ({type(error).__name__}: {error})"
        hint = "fetch it again, or make the bundle again; if the error remains, the API has changed"
        raise ProtocolError(msg, where, hint) from error


def numbers(values: Any, count: int) -> Array:
    """A list of so many finite numbers as an array (count,); else ValueError or TypeError."""
    if not isinstance(values, list) or len(values) != count:
        msg = f"expected {count} numbers, got {values!r:.80}"
        raise ValueError(msg)
    return np.array([number(value) for value in values])


def number(value: Any) -> float:
    """A finite number; else ValueError or TypeError."""
    if isinstance(value, bool) or not math.isfinite(value):
        msg = f"expected a finite number, got {value!r:.80}"
        raise ValueError(msg)
    return float(value)


def text(value: Any) -> str:
    """A string that is not empty; else TypeError."""
    if not isinstance(value, str) or not value:
        msg = f"expected a name, got {value!r:.80}"
        raise TypeError(msg)
    return value


def path_of(ids: Any) -> tuple[str, ...]:
    """A list of ids; none where there is no list."""
    return tuple(text(one) for one in ids or ())


def check_rigid(transform: Array) -> None:
    """ValueError unless a (4, 4) keeps lengths; it may reflect."""
    rotation = transform[:3, :3]
    last = transform[3] - [0.0, 0.0, 0.0, 1.0]
    if not abs(rotation @ rotation.T - np.eye(3)).max() < 1e-6 or abs(last).max() > 1e-9:
        msg = "its axes are not orthonormal"
        raise ValueError(msg)
