"""How far two surfaces are from each other, measured at many points of either."""

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface, chosen
from linkwright.stages.mesh.measure import BoxTree
from linkwright.stages.mesh.tessellation import PartMesh
from linkwright.stages.mesh.visuals.walk import WalkedSurface

_VERTICES = 10_000
"""Vertices of a surface that are looked at; of more, evenly many by their order."""

_BATCH = 32
_LARGEST_BATCH = 1024


def apart(one: PartMesh, other: PartMesh, enough: float, limit: float) -> float:
    """A bound of the two-sided Hausdorff distance [m] of two meshes with one palette, colour by colour: the
    largest distance of a point of either from the surface of its colour in the other.

    Measured at vertices and at points spread evenly; infinite where a colour is on one of them only. It
    is exact between `enough` and `limit` [m]: below, it may be too large, but is at most `enough`; above
    the limit, any larger distance may be left unseen.
    """
    worst = 0.0
    for colour in range(len(one.palette)):
        first, second = _of_colour(one, colour), _of_colour(other, colour)
        if first is None and second is None:
            continue
        if first is None or second is None:
            return float("inf")
        pair = WalkedSurface.of(first), WalkedSurface.of(second)
        for surface, target in (pair, pair[::-1]):
            worst = max(worst, _farthest(_looked_at(surface), target, enough, limit))
            if worst > limit:
                return worst
    return worst


def _of_colour(mesh: PartMesh, colour: int) -> Surface | None:
    of_it = mesh.colours == colour
    if of_it.all():
        return mesh.surface
    return chosen(mesh.surface, of_it) if of_it.any() else None


def _looked_at(walked: WalkedSurface) -> Points:
    vertices = walked.surface.vertices
    if len(vertices) > _VERTICES:
        vertices = vertices[np.linspace(0, len(vertices) - 1, _VERTICES).astype(np.int64)]
    return np.concatenate([vertices, walked.spread])


def farthest(points: Points, surface: Surface, enough: float, limit: float) -> float:
    """The largest distance [m] of points (n, 3) from a surface, with `enough` and `limit` as for `apart`."""
    return _farthest(points, WalkedSurface.of(surface), enough, limit)


def _farthest(points: Points, walked: WalkedSurface, enough: float, limit: float) -> float:
    bound = walked.bounds(points, enough)
    order = np.argsort(-bound, kind="stable")
    worst, place, batch, boxes = 0.0, 0, _BATCH, None
    while place < len(order):
        highest = float(bound[order[place]])
        if highest <= max(worst, enough):
            return max(worst, highest)
        boxes = boxes or BoxTree.of(walked.surface, cut=False)
        some = order[place : place + batch]
        worst = max(worst, float(boxes.nearer(points[some], bound[some]).max()))
        if worst > limit:
            return worst
        place, batch = place + batch, min(2 * batch, _LARGEST_BATCH)
    return worst
