"""Finds the connected components of a graph."""

import numpy as np
import numpy.typing as npt
import scipy

Indices = npt.NDArray[np.int64]


def components(count: int, first: Indices, second: Indices) -> Indices:
    """Returns the component (count,) of each node, numbered in the order of their first nodes; `first` and
    `second` (k,) are the ends of the edges."""
    links = scipy.sparse.coo_array((np.ones(len(first), dtype=np.int8), (first, second)), (count, count))
    _, label = scipy.sparse.csgraph.connected_components(links, directed=False)
    _, leaders, member = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(leaders), dtype=np.int64)
    rank[np.argsort(leaders)] = np.arange(len(leaders))
    return rank[member.ravel()]
