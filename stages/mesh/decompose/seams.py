"""Pieces that touch along a cut, and keep touching."""

from __future__ import annotations

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.fit import capped_hull
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import beyond, half_spaces

_FURTHEST = 8.0
"""A corner moves at most so many times as far as its faces; a sharper one would run away."""


def containing_hull(hull: Surface, most: int) -> Surface:
    """A convex hull with at most `most` vertices that contains this one, as near to it as they allow: one of
    least error would draw back from its neighbour along a cut."""
    if len(hull.vertices) <= most:
        return hull
    capped = capped_hull(hull, most)
    if capped is None:
        return hull
    bare = float(beyond(*half_spaces(capped), hull.vertices).max())
    return convex_hull(grown(capped, bare)) or capped if bare > 0 else capped


def grown(hull: Surface, distance: float) -> Points:
    """The corners of a convex hull, each moved so that its faces lie `distance` [m] further out."""
    normals = hull.normals()
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    corners = hull.triangles.ravel()
    of_corners = np.repeat(normals, 3, axis=0)
    outward = np.zeros_like(hull.vertices)
    for axis in range(3):
        outward[:, axis] = np.bincount(corners, of_corners[:, axis], len(outward))
    # As far as the face that this direction leaves most slowly needs.
    speed = np.full(len(outward), np.inf)
    np.minimum.at(speed, corners, (of_corners * outward[corners]).sum(axis=1))
    size = np.linalg.norm(outward, axis=1)
    speed = np.maximum(speed, size / _FURTHEST)
    steps = np.divide(distance, speed, out=np.zeros_like(speed), where=size > 0)
    return np.asarray(hull.vertices + outward * steps[:, None], dtype=np.float64)
