"""Vectors by which mass matrices are multiplied to compare them: of a large robot the products stand for the
whole, which has as many entries as its dofs squared."""

import numpy as np

from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.dynamics.tree_dynamics import WHOLE

PRODUCTS = 4
"""Vectors: an entry that is off is hidden only where others that are off cancel it in each."""

SEED = 27182


def probes(diagonal: Array) -> Array | None:
    """Seeded vectors (k, v) for mass matrices of this diagonal (n, k); None where the whole is compared.

    Random signs, each divided by the root of its dof's own entry: so that the rows of a light link count as
    much as those of a heavy one.
    """
    size = diagonal.shape[1]
    if size <= WHOLE:
        return None
    signs = np.random.Generator(np.random.PCG64(SEED)).choice([-1.0, 1.0], (size, PRODUCTS))
    vectors: Array = signs / own_sizes(diagonal[:1])[0][:, None]
    return vectors


def own_sizes(diagonal: Array) -> Array:
    """The roots of the diagonal (n, k), each at least a thousandth of the largest."""
    own = np.sqrt(np.maximum(diagonal, 0.0))
    floored: Array = np.maximum(own, 1e-3 * (float(own.max(initial=0.0)) or 1.0))
    return floored
