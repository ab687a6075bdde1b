"""Whether two values of the model are the same, field by field, up to rounding."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


def differences(one: Any, other: Any, allowed: float, left_out: Mapping[str, Any], place: str = "") -> list:
    """The places where two values differ. `allowed`: relative to the largest of an array, absolute below 1;
    `left_out`: fields that are not compared."""
    if is_dataclass(one) and type(one) is type(other):
        names = [field.name for field in fields(one) if field.name not in left_out]
        pairs = [(name, getattr(one, name), getattr(other, name)) for name in names]
    elif isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        pairs = [(str(index), *both) for index, both in enumerate(zip(one, other, strict=True))]
    elif isinstance(one, Mapping) and isinstance(other, Mapping) and one.keys() == other.keys():
        pairs = [(str(key), one[key], other[key]) for key in one]
    elif isinstance(one, float | int | np.ndarray) and not isinstance(one, bool) and other is not None:
        off = np.abs(np.asarray(one) - np.asarray(other)).max(initial=0.0)
        scale = max(1.0, float(np.abs(one).max(initial=0.0)))
        return [] if off <= allowed * scale else [(place, one, other)]
    else:
        return [] if one == other else [(place, one, other)]
    found = []
    for name, first, second in pairs:
        found += differences(first, second, allowed, left_out, f"{place}.{name}")
    return found
