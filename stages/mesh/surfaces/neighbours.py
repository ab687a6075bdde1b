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
    are_equal = _equal_neighbours(edges, order)
    if (are_equal[1:] & are_equal[:-1]).any():
        order = np.argsort(edges, kind="stable")
        are_equal = _equal_neighbours(edges, order)
    first, second = order[:-1][are_equal], order[1:][are_equal]
    opposite = starts[first] != starts[second]
    first, second = first[opposite], second[opposite]
    neighbour_of_edge = np.repeat(np.arange(len(surface.triangles)), 3)
    neighbour_of_edge[first], neighbour_of_edge[second] = second // 3, first // 3
    return neighbour_of_edge.reshape(-1, 3)


def _equal_neighbours(keys: npt.NDArray[np.int64], order: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    ordered = keys[order]
    return np.asarray(ordered[1:] == ordered[:-1])
