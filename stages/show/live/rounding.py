"""Rounds the numbers of the pack: short in JSON, and exact enough for kinematics to 1e-9."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.errors import ExportError

_DIGITS = 12


def rounded(value: float) -> float:
    """Rounds a number to 12 digits, without a negative zero. Raises ExportError if it is not finite."""
    if not np.isfinite(value):
        raise ExportError(f"the compiled model has the number {value}", "report.html", "")
    return float(f"{float(value):.{_DIGITS}g}") + 0.0


def vector(values: Iterable[Any] | npt.NDArray[Any]) -> list[float]:
    """Returns the rounded numbers of an array as a list for the header."""
    return [rounded(float(value)) for value in np.asarray(values, dtype=np.float64).ravel()]
