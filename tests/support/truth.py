"""Whether two values of the model are the same, field by field, up to rounding."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass

import numpy as np


def differences(first, other, allowed, left_out, place=""):
    """The places where two values differ. `allowed`: relative to the largest of an array, absolute below 1;
    `left_out`: fields that are not compared."""
    if is_dataclass(first) and type(first) is type(other):
        names = [field.name for field in fields(first) if field.name not in left_out]
        pairs = [(name, getattr(first, name), getattr(other, name)) for name in names]
    elif isinstance(first, tuple) and isinstance(other, tuple) and len(first) == len(other):
        pairs = [(str(index), *both) for index, both in enumerate(zip(first, other, strict=True))]
    elif isinstance(first, Mapping) and isinstance(other, Mapping) and first.keys() == other.keys():
        pairs = [(str(key), first[key], other[key]) for key in first]
    elif isinstance(first, float | int | np.ndarray) and not isinstance(first, bool) and other is not None:
        off = np.abs(np.asarray(first) - np.asarray(other)).max(initial=0.0)
        scale = max(1.0, float(np.abs(first).max(initial=0.0)))
        return [] if off <= allowed * scale else [(place, first, other)]
    else:
        return [] if first == other else [(place, first, other)]
    found = []
    for name, first, second in pairs:
        found += differences(first, second, allowed, left_out, f"{place}.{name}")
    return found
