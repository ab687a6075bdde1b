"""Convex hulls of few vertices."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import along, beyond, half_spaces

_OUTWARDS = 0.5
"""How far the vertices are moved out, as a share of what they leave bare: so the hull stands out as far as it
leaves bare. On the hulls of 49 robot parts, with 64 vertices, that is an error of 0.12 times the usual
tolerance (at most 0.57), without it 0.21 (1.1); that of quadric simplification has 2.8 (23)."""

_LOOKED_AT = 150
"""Points looked at first. All of a hull's thousand corners at each step take twice as long, and leave as much
bare."""


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
    """Indices of `count` points, each far from the hull of those before, ties to the first.

    A point is seldom farther from a larger hull: those that were near to a smaller hull are not looked at
    while another one is farther than they were.
    """
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.spatial import ConvexHull

    chosen = _start(points)
    known = np.full(len(points), np.inf)
    known[chosen] = 0.0
    while len(chosen) < count:
        # Anew each time: a hull to which Qhull adds points gets wide faces where many are nearly in one.
        planes, before = ConvexHull(points[chosen]).equations, known.copy()
        order = _largest(before, _LOOKED_AT)
        begin, end, farthest = 0, _LOOKED_AT, 0.0
        while begin < len(order) and before[order[begin]] > farthest:
            some = order[begin:end]
            heights = along(planes[:, :3], points[some]) + planes[:, 3:]
            known[some] = np.where(known[some] > 0.0, heights.max(axis=0), 0.0)
            farthest = max(farthest, float(known[some].max()))
            begin, end = end, 3 * end
            order = _largest(before, end) if begin == len(order) else order
        if farthest <= 0.0:
            break
        chosen.append(int(known.argmax()))
        known[chosen[-1]] = 0.0
    return np.array(sorted(chosen), dtype=np.int64)


def _largest(numbers: npt.NDArray[np.float64], count: int) -> npt.NDArray[np.int64]:
    """Indices of the `count` largest numbers, the largest first, ties to the first."""
    least = np.partition(numbers, -count)[-count] if count < len(numbers) else -np.inf
    some = np.flatnonzero(numbers >= least)
    return some[np.argsort(-numbers[some], kind="stable")][:count]


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
