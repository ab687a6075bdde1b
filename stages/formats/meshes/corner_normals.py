"""Computes normals of a surface that is smooth where its faces meet at a small angle, and has an edge
elsewhere."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.components import components
from linkwright.stages.formats.meshes.surface import Surface, unit_vectors

CREASE = 0.85
"""Cosine of the largest angle between two faces (about 32°) that meet smoothly; at a larger angle the edge is
sharp."""

Numbers = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


def corner_normals(surface: Surface) -> tuple[Indices, Numbers]:
    """Returns (m, 3), the index of the normal of each corner of each triangle, and (k, 3), the unit normals.
    Corners with the same normal are at the same point.

    Across a smooth edge both triangles share their normals: the normal is the mean, weighted by area, of all
    triangles around the point that smooth edges connect.
    """
    # The length of each is twice the area of its triangle, so that their sums are weighted by area.
    area_normals = surface.normals()
    first, second = _joined_corners(surface.triangles, len(surface.vertices), unit_vectors(area_normals))
    normal_of_corner = components(surface.triangles.size, first, second)
    triangle_of_corner = np.arange(surface.triangles.size) // 3
    sums = [
        np.bincount(normal_of_corner, area_normals[triangle_of_corner, axis]).astype(np.float64)
        for axis in range(3)
    ]
    return normal_of_corner.reshape(-1, 3), unit_vectors(np.stack(sums, axis=1))


def _joined_corners(triangles: Indices, point_count: int, face_normals: Numbers) -> tuple[Indices, Indices]:
    """Returns the pairs of corners (counted through all triangles) on either side of the smooth edges.

    `face_normals` (m, 3): the unit normals of the triangles.
    """
    corner = np.arange(triangles.size)
    following = corner.reshape(-1, 3)[:, (1, 2, 0)].ravel()
    starts, ends = triangles.ravel(), triangles[:, (1, 2, 0)].ravel()
    # Each edge as a number, the same for both directions, and its corners at the lower and the higher point.
    rises = starts < ends
    low, high = np.where(rises, corner, following), np.where(rises, following, corner)
    edges = np.where(rises, starts * point_count + ends, ends * point_count + starts)
    order = np.argsort(edges, kind="stable")
    same_edge = edges[order[1:]] == edges[order[:-1]]
    a, b = order[:-1][same_edge], order[1:][same_edge]
    x, y, z = (face_normals[a // 3] * face_normals[b // 3]).T
    smooth = x + y + z > CREASE
    a, b = a[smooth], b[smooth]
    return np.concatenate([low[a], high[a]]), np.concatenate([low[b], high[b]])
