"""Pieces of a surface that lies around a part, drawn in to the part itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stages.mesh.convex_hull import convex_hull
from stages.mesh.decompose.remesh import dense, one_a_cell
from stages.mesh.pieces import along, half_spaces
from stages.mesh.surface import Points, Surface

_DENSE = 0.5
_CELL = 0.25
"""Of the points in so small a cube one is enough. Both in distances of the surface from the part."""

_FINE = 0.05
"""How far a corner of a piece may be moved to have fewer of them, in tolerances."""


def tightened(parts: Sequence[Points], surface: Surface, around: float, tolerance: float) -> list[Points]:
    """Each piece (its corners) as the hull of what it holds of the surface.

    A piece keeps what is just beyond it too, so that neighbours overlap and no gap opens between them. One
    that holds a flat sheet stays as it is, since a sheet has no inside; one that holds nothing, being within
    the part, is left out.
    """
    points = one_a_cell(dense(surface, _DENSE * around), _CELL * around)
    found = []
    for part in parts:
        thick = convex_hull(part)
        if thick is None:
            continue
        held = _held(points, thick, _DENSE * around)
        if len(held):
            thin = convex_hull(held)
            found.append(thick.vertices if thin is None else _plainer(thin, _FINE * tolerance))
    return found


def _held(points: Points, piece: Surface, beyond: float) -> Points:
    """The points within the piece, or at most `beyond` outside each of its planes."""
    low, high = piece.vertices.min(axis=0) - beyond, piece.vertices.max(axis=0) + beyond
    held: Points = points[((points >= low) & (points <= high)).all(axis=1)]
    for normal, height in zip(*half_spaces(piece), strict=True):
        held = held[along(normal[None], held)[0] <= height + beyond]
    return held


def _plainer(hull: Surface, bound: float) -> Points:
    """The corners of a hull without those that change it by less than `bound` [m]."""
    import manifold3d

    mesh = manifold3d.Mesh64(hull.vertices, hull.triangles.astype(np.uint64))
    simple = manifold3d.Manifold(mesh).simplify(bound).to_mesh64()
    vertices = np.array(simple.vert_properties, dtype=np.float64)[:, :3]
    return np.asarray(vertices if len(vertices) >= 4 else hull.vertices, dtype=np.float64)
