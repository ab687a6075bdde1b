"""The neighbours of a surface's triangles."""

import numpy as np
import numpy.typing as npt

from stages.mesh.surface import Surface


def neighbours(surface: Surface) -> npt.NDArray[np.int64]:
    """(m, 3): the triangle across each edge, of which edge k leads from corner k to the next.

    That is a triangle with the same edge in the opposite sense; the triangle itself where there is none.
    """
    starts, ends = surface.triangles.ravel(), surface.triangles[:, (1, 2, 0)].ravel()
    count = np.int64(len(surface.vertices))
    forth, back = starts * count + ends, ends * count + starts
    by_forth, by_back = np.argsort(forth, kind="stable"), np.argsort(back, kind="stable")
    forth, back = forth[by_forth], back[by_back]
    across = np.repeat(np.arange(len(surface.triangles)), 3)
    if np.array_equal(forth, back):
        across[by_back] = by_forth // 3
    else:
        place = np.minimum(np.searchsorted(forth, back), len(forth) - 1)
        met = forth[place] == back
        across[by_back[met]] = by_forth[place[met]] // 3
    return across.reshape(-1, 3)
