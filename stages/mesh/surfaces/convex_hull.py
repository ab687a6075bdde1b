"""The convex hull of points."""

from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface, compacted, weld
from linkwright.stages.formats.triangles import distinct

_THIN = 1e-6
"""A hull of less mean thickness [m], or a millionth of its size, has no inside to collide with."""


def convex_hull(points: Points) -> Surface | None:
    """The hull of (n, 3) points, facing outwards; None where they are flat.

    Points and faces are sorted, and Qhull sees the points sorted, so that their order in the input
    does not matter.
    """
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.spatial import ConvexHull, QhullError

    corners, _ = distinct(points)
    if len(corners) < 4:
        return None
    try:
        hull = ConvexHull(corners)
    except QhullError:
        return None
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    if hull.volume <= hull.area / 2 * _THIN * min(1.0, size):
        return None
    surface = compacted(Surface(corners, hull.simplices.astype(np.int64)))
    welded, _ = weld(surface.vertices, outwards(surface, hull))
    return welded


def outwards(surface: Surface, hull: Any) -> npt.NDArray[np.int64]:
    """The triangles (m, 3) of a surface made of Qhull's hull, in its order, facing outwards: Qhull gives each
    the outward normal of its plane, but its corners in any sense."""
    inward = np.einsum("ij,ij->i", surface.normals(), hull.equations[:, :3]) < 0
    return np.where(inward[:, None], surface.triangles[:, ::-1], surface.triangles)
