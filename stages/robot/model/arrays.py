"""Makes the arrays of the model, which are read-only."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
"""An array of float64, the numbers of the model."""


def frozen(values: object, numbers: Any = np.float64) -> npt.NDArray[Any]:
    """Returns a read-only copy of `values` as an array. `numbers`: the dtype."""
    array = np.array(values, dtype=numbers)
    array.setflags(write=False)
    return array
