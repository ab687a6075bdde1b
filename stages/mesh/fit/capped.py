"""Convex hulls of few vertices."""

import numpy as np
import numpy.typing as npt

from stages.mesh.convex_hull import convex_hull
from stages.mesh.pieces import along, beyond, half_spaces
from stages.mesh.surface import Points, Surface

_OUTWARDS = 0.5
"""How far the vertices are moved out, as a share of what they leave bare: so the hull stands out as far as it
leaves bare. On the hulls of 49 robot parts, with 64 vertices, that is an error of 0.12 times the usual
tolerance (at most 0.57), without it 0.21 (1.1); that of quadric simplification has 2.8 (23)."""


def capped_hull(surface: Surface, max_vertices: int) -> Surface | None:
    """The convex hull of a surface, with at most `max_vertices` (≥ 4); None where the surface is flat.

    Of a hull with more it has those that, one after the other, are farthest outside of the hull of the ones
    before, moved outwards by half of what they leave bare.
    """
    whole = convex_hull(surface.vertices)
    if whole is None or len(whole.vertices) <= max_vertices:
        return whole
    inner = convex_hull(whole.vertices[_farthest(whole.vertices, max_vertices)])
    if inner is None:
        return None
    bare = float(beyond(*half_spaces(inner), whole.vertices).max())
    return _moved_out(inner, _OUTWARDS * bare)


def _moved_out(hull: Surface, distance: float) -> Surface:
    """The hull with its vertices moved by `distance` [m] along their normals."""
    normals = np.zeros_like(hull.vertices)
    faces = hull.normals()
    for corner in range(3):
        np.add.at(normals, hull.triangles[:, corner], faces)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return convex_hull(hull.vertices + distance * normals) or hull


def _farthest(points: Points, count: int) -> npt.NDArray[np.int64]:
    """Indices of `count` points, each the farthest from the hull of those before, ties to the first."""
    from scipy.spatial import ConvexHull

    chosen = _start(points)
    while len(chosen) < count:
        planes = ConvexHull(points[chosen]).equations
        heights = along(planes[:, :3], points) + planes[:, 3:]
        farthest = int(heights.max(axis=0).argmax())
        if farthest in chosen:
            break
        chosen.append(farthest)
    return np.array(sorted(chosen), dtype=np.int64)


def _start(points: Points) -> list[int]:
    """Four points of a large tetrahedron."""
    apart = points - points.mean(axis=0)
    first = int((apart**2).sum(axis=1).argmax())
    apart = points - points[first]
    second = int((apart**2).sum(axis=1).argmax())
    axis = apart[second] / np.linalg.norm(apart[second])
    sideways = apart - np.outer(apart @ axis, axis)
    third = int((sideways**2).sum(axis=1).argmax())
    fourth = int(np.abs(apart @ np.cross(axis, sideways[third])).argmax())
    return [first, second, third, fourth]
