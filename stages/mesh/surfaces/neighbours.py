"""Finds the neighbours of a surface's triangles."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Surface


def neighbours(surface: Surface) -> npt.NDArray[np.int64]:
    """Returns the index of the triangle across each edge (m, 3); edge k leads from corner k to the next.

    The neighbour has the same edge in the opposite sense; without such a triangle, it is the triangle itself.
    """
    starts, ends = surface.triangles.ravel(), surface.triangles[:, (1, 2, 0)].ravel()
    edges = np.minimum(starts, ends) * np.int64(len(surface.vertices)) + np.maximum(starts, ends)
    # A sort that need not keep the order of equal keys takes a quarter of the time; pairs need no order.
    order = np.argsort(edges)
    same = _equal_neighbours(edges, order)
    if (same[1:] & same[:-1]).any():
        order = np.argsort(edges, kind="stable")
        same = _equal_neighbours(edges, order)
    first, second = order[:-1][same], order[1:][same]
    opposite = starts[first] != starts[second]
    first, second = first[opposite], second[opposite]
    across = np.repeat(np.arange(len(surface.triangles)), 3)
    across[first], across[second] = second // 3, first // 3
    return across.reshape(-1, 3)


def _equal_neighbours(keys: npt.NDArray[np.int64], order: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    ordered = keys[order]
    return np.asarray(ordered[1:] == ordered[:-1])
