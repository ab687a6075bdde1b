"""Rounds the numbers that a live view is given: few digits in JSON, but enough for kinematics exact to
1e-9."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.errors import ExportError

_SIGNIFICANT_DIGITS = 12


def rounded(value: float) -> float:
    """Rounds a number to 12 significant digits, without a negative zero. Raises ExportError if it is not
    finite."""
    if not np.isfinite(value):
        raise ExportError(f"the compiled model contains {value}, which cannot be shown", "report.html", "")
    return float(f"{float(value):.{_SIGNIFICANT_DIGITS}g}") + 0.0


def rounded_list(values: Iterable[Any] | npt.NDArray[Any]) -> list[float]:
    """Returns the rounded numbers of an array as a flat list, for the JSON of the live view."""
    return [rounded(float(value)) for value in np.asarray(values, dtype=np.float64).ravel()]
