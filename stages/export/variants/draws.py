"""Draws random numbers that are the same on every machine and under any version of any library.

A number is a hash (BLAKE2b) of the seed, the quantity and the variant: a draw depends neither on the number
of variants nor on the other quantities.
"""

from hashlib import blake2b

import numpy as np
import numpy.typing as npt

Column = npt.NDArray[np.float64]
"""One number for each variant (n,)."""

MAX_COUNT = 8
"""Largest number of columns: a hash of 64 bytes holds as many numbers."""


def draws(seed: int, quantity: str, n: int, count: int) -> list[Column]:
    """Returns `count` columns (at most 8), each with the numbers of the variants 0 to n - 1, evenly spread
    over -1 to 1."""
    start = blake2b(f"{seed}\n{quantity}\n".encode(), digest_size=8 * count)
    digests = []
    for variant in range(n):
        hashed = start.copy()
        hashed.update(b"%d" % variant)
        digests.append(hashed.digest())
    integers = np.frombuffer(b"".join(digests), "<u8").reshape(n, count) >> 11
    # A float64 holds 53 bits, so each step is exact.
    return list((integers.astype(np.float64) * 2.0**-52 - 1.0).T)
