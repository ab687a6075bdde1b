"""Converts vectors of numpy to the form that a look has: rounded, and plain data."""

from typing import Any

import numpy as np

from linkwright.stages.show.preview.look import Vector

_DIGITS = 9
"""Number of decimals of a position [m], and of a direction; further decimals are noise."""


def vector(numbers: Any) -> Vector:
    """Returns the rounded numbers of an array of any shape."""
    return tuple(round(float(number), _DIGITS) + 0.0 for number in np.reshape(numbers, -1))
