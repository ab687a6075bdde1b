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
    bareness = float(beyond(*half_spaces(capped), hull.vertices).max())
    return (convex_hull(expanded_corners(capped, bareness)) or capped) if bareness > 0 else capped


def expanded_corners(hull: Surface, distance: float) -> Points:
    """Returns the corners of a convex hull, moved so that its faces are `distance` [m] further out. Faces at
    corners that `_MAX_STRETCH` limits move less."""
    normals = hull.normals()
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    # Triangles without area have no normal.
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    corners = hull.triangles.ravel()
    corner_normals = np.repeat(normals, 3, axis=0)
    outward = np.zeros_like(hull.vertices)
    for axis in range(3):
        outward[:, axis] = np.bincount(corners, corner_normals[:, axis], len(outward))
    # `face_moves`: how far a corner's slowest face moves if the corner moves by `outward`. The corner moves
    # along it until that face has moved by `distance`.
    face_moves = np.full(len(outward), np.inf)
    np.minimum.at(face_moves, corners, (corner_normals * outward[corners]).sum(axis=1))
    outward_lengths = np.linalg.norm(outward, axis=1)
    # See `_MAX_STRETCH`.
    face_moves = np.maximum(face_moves, outward_lengths / _MAX_STRETCH)
    steps = np.divide(distance, face_moves, out=np.zeros_like(face_moves), where=outward_lengths > 0)
    return np.asarray(hull.vertices + outward * steps[:, None], dtype=np.float64)
