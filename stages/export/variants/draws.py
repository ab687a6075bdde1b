"""Draws random numbers that are the same on every machine and under any version of any library.

A number is a hash (BLAKE2b) of the seed, the quantity and the variant: a draw depends neither on the number
of variants nor on the other quantities.
"""

from hashlib import blake2b

import numpy as np
import numpy.typing as npt

Column = npt.NDArray[np.float64]
"""One number for each variant (n,)."""


def draws(seed: int, quantity: str, n: int, count: int) -> list[Column]:
    """Returns `count` columns, each with the numbers of the variants 0 to n - 1, evenly spread over -1 to 1.
    At most 8 columns: each needs 8 bytes of a hash, which has at most 64."""
    common_hash = blake2b(f"{seed}\n{quantity}\n".encode(), digest_size=8 * count)
    digests = []
    for variant in range(n):
        variant_hash = common_hash.copy()
        variant_hash.update(b"%d" % variant)
        digests.append(variant_hash.digest())
    integers = np.frombuffer(b"".join(digests), "<u8").reshape(n, count) >> 11
    # A float64 holds 53 bits, so each step is exact.
    return list((integers.astype(np.float64) * 2.0**-52 - 1.0).T)
