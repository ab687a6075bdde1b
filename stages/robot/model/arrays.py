"""Arrays of the model: float64 and read-only."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def frozen(values: object) -> Array:
    """A read-only float64 array of `values`."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array
