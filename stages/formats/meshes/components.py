"""Finds the connected components of a graph."""

import numpy as np
import numpy.typing as npt
import scipy

Indices = npt.NDArray[np.int64]


def components(count: int, first: Indices, second: Indices) -> Indices:
    """Returns the component (count,) of each node, numbered in the order of their first nodes; `first` and
    `second` (k,) are the ends of the edges."""
    edges = scipy.sparse.coo_array((np.ones(len(first), dtype=np.int8), (first, second)), (count, count))
    _, labels = scipy.sparse.csgraph.connected_components(edges, directed=False)
    _, first_nodes, label_index = np.unique(labels, return_index=True, return_inverse=True)
    # SciPy does not promise an order of its labels.
    rank = np.empty(len(first_nodes), dtype=np.int64)
    rank[np.argsort(first_nodes)] = np.arange(len(first_nodes))
    return rank[label_index.ravel()]
