"""Limits the vertices of pieces without opening a gap where pieces touch along a cut."""

from __future__ import annotations

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.fit import capped_hull
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import beyond, half_spaces

_MAX_STRETCH = 8.0
"""Largest ratio between the moves of a corner and of its faces: sharper corners would run away."""


def containing_hull(hull: Surface, max_vertices: int) -> Surface:
    """Returns a convex hull with at most `max_vertices` vertices that contains the given one, and is as near
    to it as so few vertices allow. A hull of least error would draw back from its neighbour along a cut."""
    if len(hull.vertices) <= max_vertices:
        return hull
    capped = capped_hull(hull, max_vertices)
    if capped is None:
        return hull
    bare = float(beyond(*half_spaces(capped), hull.vertices).max())
    return convex_hull(grown(capped, bare)) or capped if bare > 0 else capped


def grown(hull: Surface, distance: float) -> Points:
    """Returns the corners of a convex hull, moved so that its faces are `distance` [m] further out."""
    normals = hull.normals()
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    corners = hull.triangles.ravel()
    of_corners = np.repeat(normals, 3, axis=0)
    outward = np.zeros_like(hull.vertices)
    for axis in range(3):
        outward[:, axis] = np.bincount(corners, of_corners[:, axis], len(outward))
    # A corner moves as far as the face needs that its direction leaves most slowly.
    speed = np.full(len(outward), np.inf)
    np.minimum.at(speed, corners, (of_corners * outward[corners]).sum(axis=1))
    size = np.linalg.norm(outward, axis=1)
    speed = np.maximum(speed, size / _MAX_STRETCH)
    steps = np.divide(distance, speed, out=np.zeros_like(speed), where=size > 0)
    return np.asarray(hull.vertices + outward * steps[:, None], dtype=np.float64)
