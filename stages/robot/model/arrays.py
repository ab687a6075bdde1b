"""Makes the arrays of the model: float64 and read-only."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def frozen(values: object, numbers: Any = np.float64) -> npt.NDArray[Any]:
    """Returns a read-only array of `values`."""
    array = np.array(values, dtype=numbers)
    array.setflags(write=False)
    return array
