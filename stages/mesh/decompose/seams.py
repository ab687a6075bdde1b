"""Limits the vertices of pieces without opening a gap where pieces touch along a cut."""

from __future__ import annotations

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.fit import capped_hull
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import beyond, half_spaces

_MAX_STRETCH = 8.0
"""Largest move of a corner, as a multiple of the move of its faces: sharp corners would otherwise move almost
without bound."""


def containing_hull(hull: Surface, max_vertices: int) -> Surface:
    """Returns a convex hull with at most `max_vertices` vertices that contains the given hull and stays close
    to it. A hull of least error would leave some vertices outside, and so a gap along a cut."""
    if len(hull.vertices) <= max_vertices:
        return hull
    capped = capped_hull(hull, max_vertices)
    if capped is None:
        return hull
    bare = float(beyond(*half_spaces(capped), hull.vertices).max())
    return convex_hull(grown(capped, bare)) or capped if bare > 0 else capped


def grown(hull: Surface, distance: float) -> Points:
    """Returns the corners of a convex hull, moved so that its faces are `distance` [m] further out. Faces at
    corners that `_MAX_STRETCH` limits move less."""
    normals = hull.normals()
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    # Triangles without area have no normal.
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    corners = hull.triangles.ravel()
    of_corners = np.repeat(normals, 3, axis=0)
    outward = np.zeros_like(hull.vertices)
    for axis in range(3):
        outward[:, axis] = np.bincount(corners, of_corners[:, axis], len(outward))
    # A corner moves along `outward` until each of its faces has moved by `distance`; the slowest face
    # decides.
    speed = np.full(len(outward), np.inf)
    np.minimum.at(speed, corners, (of_corners * outward[corners]).sum(axis=1))
    size = np.linalg.norm(outward, axis=1)
    # See `_MAX_STRETCH`.
    speed = np.maximum(speed, size / _MAX_STRETCH)
    steps = np.divide(distance, speed, out=np.zeros_like(speed), where=size > 0)
    return np.asarray(hull.vertices + outward * steps[:, None], dtype=np.float64)
