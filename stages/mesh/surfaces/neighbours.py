"""The neighbours of a surface's triangles."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Surface


def neighbours(surface: Surface) -> npt.NDArray[np.int64]:
    """(m, 3): the triangle across each edge, of which edge k leads from corner k to the next.

    That is a triangle with the same edge in the opposite sense; the triangle itself where there is none.
    """
    starts, ends = surface.triangles.ravel(), surface.triangles[:, (1, 2, 0)].ravel()
    edges = np.minimum(starts, ends) * np.int64(len(surface.vertices)) + np.maximum(starts, ends)
    # A sort that need not keep the order of equal keys takes a quarter of the time; pairs need no order.
    order = np.argsort(edges)
    same = _same(edges, order)
    if (same[1:] & same[:-1]).any():
        order = np.argsort(edges, kind="stable")
        same = _same(edges, order)
    one, other = order[:-1][same], order[1:][same]
    opposite = starts[one] != starts[other]
    one, other = one[opposite], other[opposite]
    across = np.repeat(np.arange(len(surface.triangles)), 3)
    across[one], across[other] = other // 3, one // 3
    return across.reshape(-1, 3)


def _same(keys: npt.NDArray[np.int64], order: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    ordered = keys[order]
    return np.asarray(ordered[1:] == ordered[:-1])
