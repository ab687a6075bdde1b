"""Measures the largest distance between two surfaces, at many points of both."""

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface, select_triangles
from linkwright.stages.mesh.measure import BoxTree
from linkwright.stages.mesh.part_mesh import PartMesh
from linkwright.stages.mesh.visuals.walk import WalkedSurface

_MAX_VERTICES = 10_000
"""Largest number of vertices of a surface that are tried; from more, this many are picked evenly by index."""

_BATCH = 32
_MAX_BATCH = 1024
"""Numbers of points in the first batch and in the largest: a batch is measured exactly at once, and each has
twice as many points as the one before, since the first points mostly decide."""


def hausdorff_bound(mesh: PartMesh, other: PartMesh, enough: float, limit: float) -> float:
    """Returns a bound of the two-sided Hausdorff distance [m] of two meshes with the same palette.

    Distances are measured within each colour: from the points of a colour in one mesh to the surface of that
    colour in the other mesh. The points are vertices, and points spread evenly. The result is infinite if
    only one of the meshes has a colour. It is exact between `enough` and `limit` [m]. Below `enough` it may
    be too large, but is at most `enough`; once it exceeds `limit`, the search stops, and larger distances may
    exist.
    """
    worst = 0.0
    for colour in range(len(mesh.palette)):
        first, second = _of_colour(mesh, colour), _of_colour(other, colour)
        if first is None and second is None:
            continue
        if first is None or second is None:
            return float("inf")
        pair = WalkedSurface.of(first), WalkedSurface.of(second)
        for surface, target in (pair, pair[::-1]):
            worst = max(worst, _farthest(_sample_points(surface), target, enough, limit))
            if worst > limit:
                return worst
    return worst


def _of_colour(mesh: PartMesh, colour: int) -> Surface | None:
    mask = mesh.colours == colour
    if mask.all():
        return mesh.surface
    return select_triangles(mesh.surface, mask) if mask.any() else None


def _sample_points(walked: WalkedSurface) -> Points:
    vertices = walked.surface.vertices
    if len(vertices) > _MAX_VERTICES:
        vertices = vertices[np.linspace(0, len(vertices) - 1, _MAX_VERTICES).astype(np.int64)]
    return np.concatenate([vertices, walked.spread])


def farthest(points: Points, surface: Surface, enough: float, limit: float) -> float:
    """Returns the largest distance [m] of points (n, 3) from a surface, with `enough` and `limit` as for
    `hausdorff_bound`."""
    return _farthest(points, WalkedSurface.of(surface), enough, limit)


def _farthest(points: Points, walked: WalkedSurface, enough: float, limit: float) -> float:
    bound = walked.bounds(points, enough)
    order = np.argsort(-bound, kind="stable")
    worst, start, batch, boxes = 0.0, 0, _BATCH, None
    while start < len(order):
        highest = float(bound[order[start]])
        if highest <= max(worst, enough):
            return max(worst, highest)
        boxes = boxes or BoxTree.of(walked.surface, cut=False)
        indices = order[start : start + batch]
        worst = max(worst, float(boxes.nearer(points[indices], bound[indices]).max()))
        if worst > limit:
            return worst
        start, batch = start + batch, min(2 * batch, _MAX_BATCH)
    return worst
