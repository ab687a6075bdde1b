"""Makes the vectors by which mass matrices are multiplied to compare them.

For a large robot the products replace the whole matrix, which has as many entries as its dofs squared.
"""

import numpy as np

from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.dynamics.tree_dynamics import MAX_WHOLE_DOFS

PROBE_COUNT = 4
"""Number of vectors: a wrong entry is hidden only if other wrong entries cancel it in each product."""

SEED = 27182
"""An arbitrary seed, so that the vectors are the same in every run."""


def probe_vectors(diagonal: Array) -> Array | None:
    """Returns seeded vectors (k, v) for mass matrices with this diagonal (n, k); None for small robots, whose
    whole matrix is compared.

    They have random signs, each divided by the root of its dof's own entry, so that the rows of a light link
    count as much as those of a heavy link.
    """
    size = diagonal.shape[1]
    if size <= MAX_WHOLE_DOFS:
        return None
    signs = np.random.Generator(np.random.PCG64(SEED)).choice([-1.0, 1.0], (size, PROBE_COUNT))
    vectors: Array = signs / inertia_roots(diagonal[:1])[0][:, None]
    return vectors


def inertia_roots(diagonal: Array) -> Array:
    """Returns the roots of the diagonal (n, k), each at least a thousandth of the largest."""
    roots = np.sqrt(np.maximum(diagonal, 0.0))
    floored: Array = np.maximum(roots, 1e-3 * (float(roots.max(initial=0.0)) or 1.0))
    return floored
