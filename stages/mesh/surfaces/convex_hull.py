"""Computes the convex hull of points."""

from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from linkwright.stages.formats.meshes.body_arrays import distinct
from linkwright.stages.formats.meshes.surface import Points, Surface, drop_unused_points, weld

_MIN_THICKNESS = 1e-6
"""Hulls with a smaller mean thickness are flat: in [m], or as a share of the diagonal if that is below 1
m."""


def convex_hull(points: Points) -> Surface | None:
    """Returns the hull of points (n, 3), facing outwards; None if they are flat.

    Qhull gets the points sorted, and the points and faces of the result are sorted, so that the order of the
    input does not matter.
    """
    corners, _ = distinct(points)
    if len(corners) < 4:
        return None
    try:
        hull = scipy.spatial.ConvexHull(corners)
    except scipy.spatial.QhullError:
        return None
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    if hull.volume <= hull.area / 2 * _MIN_THICKNESS * min(1.0, size):
        return None
    surface = drop_unused_points(Surface(corners, hull.simplices.astype(np.int64)))
    welded, _ = weld(surface.vertices, outwards(surface, hull))
    return welded


def outwards(surface: Surface, hull: Any) -> npt.NDArray[np.int64]:
    """Returns the triangles (m, 3) of a surface made from Qhull's hull, in the same order, facing outwards.
    Qhull gives the outward normal of each triangle's plane, but its corners in either sense."""
    inward = np.einsum("ij,ij->i", surface.normals(), hull.equations[:, :3]) < 0
    return np.where(inward[:, None], surface.triangles[:, ::-1], surface.triangles)
