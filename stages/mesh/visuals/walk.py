"""Finds upper bounds of the distances of many points from a surface by walking across its triangles."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure import evenly_spread
from linkwright.stages.mesh.surfaces.neighbours import neighbours

Numbers = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_MAX_STEPS = 6
"""Largest number of steps of a walk: nearly all walks have ended by then."""

_SAMPLE_LIMITS = 2_000, 10_000
"""Smallest and largest number of points that are spread evenly over a surface."""

_PER_TRIANGLE = 4
"""Points for each triangle, within the limits above: more points on small parts change the error by a few
percent."""


@dataclass(frozen=True, slots=True, eq=False)
class WalkedSurface:
    """A surface that is prepared for walks across its triangles."""

    surface: Surface
    corners: Numbers
    """Corners of the triangles (m, 3, 3)."""
    across: Indices
    """Index of the triangle across each edge (m, 3)."""
    spread: Points
    """Points that are spread evenly on the surface (k, 3)."""
    starts: Any
    """KD-tree of the points where walks begin: `spread`, then the centroids of the triangles."""
    owners: Indices
    """Index of the triangle that each start lies on (k + m,)."""

    @staticmethod
    def of(surface: Surface) -> "WalkedSurface":
        """Prepares a surface."""
        corners = surface.corners
        least, most = _SAMPLE_LIMITS
        spread = evenly_spread(corners, min(max(_PER_TRIANGLE * len(corners), least), most))
        places = np.concatenate([spread.points, (corners[:, 0] + corners[:, 1] + corners[:, 2]) / 3])
        owners = np.concatenate([spread.triangles, np.arange(len(corners))])
        # A balanced tree takes four times as long to make, and is searched no faster.
        tree = scipy.spatial.cKDTree(places, balanced_tree=False, compact_nodes=False)
        return WalkedSurface(surface, corners, neighbours(surface), spread.points, tree, owners)

    def bounds(self, points: Points, enough: float) -> Numbers:
        """Returns an upper bound (n,) of the distance [m] of each of the points (n, 3) from the surface.

        A walk begins in the triangle of the nearest start. Each step crosses the edge that the point is
        farthest beyond, until a triangle is within `enough` [m] of the point.
        """
        _, nearest = self.starts.query(points)
        triangles = self.owners[nearest]
        bound, edge = _edge_distances(points, self.corners.take(triangles, axis=0))
        walking = np.arange(len(points))
        for _ in range(_MAX_STEPS):
            active = bound[walking] > enough
            walking, triangles, edge = walking[active], triangles[active], edge[active]
            if not len(walking):
                break
            triangles = self.across[triangles, edge]
            distance, edge = _edge_distances(
                points.take(walking, axis=0), self.corners.take(triangles, axis=0)
            )
            bound[walking] = np.minimum(bound[walking], distance)
        return bound


def _edge_distances(points: Points, corners: Numbers) -> tuple[Numbers, npt.NDArray[np.intp]]:
    """Returns the distance [m] (n,) of each of the points (n, 3) from its own triangle (n, 3, 3), and the
    index (n,) of the edge that it is farthest beyond, seen along the triangle's normal.

    For a triangle without area the distance is measured from its edges. Each coordinate has its own array,
    which makes NumPy twice as fast.
    """
    x, y, z = np.ascontiguousarray(corners.transpose(2, 1, 0))
    # Row k: from corner k, and from corner k to the next.
    from_corners = points[:, 0] - x, points[:, 1] - y, points[:, 2] - z
    edges = np.roll(x, -1, axis=0) - x, np.roll(y, -1, axis=0) - y, np.roll(z, -1, axis=0) - z
    normal = _cross(_picked(edges, 0), _picked(edges, 1))
    area = _dot(normal, normal)
    lengths = _dot(edges, edges)
    edge_sides = _dot(_cross(edges, from_corners), normal)
    edge = (edge_sides / np.sqrt(np.where(lengths > 0.0, lengths, 1.0))).argmin(axis=0)
    height = _dot(_picked(from_corners, 0), normal)
    squared = height * height / np.where(area > 0.0, area, 1.0)
    outside = np.flatnonzero((edge_sides < 0.0).any(axis=0) | (area == 0.0))
    from_corners, edges, lengths = (
        _picked(from_corners, np.s_[:, outside]),
        _picked(edges, np.s_[:, outside]),
        lengths[:, outside],
    )
    share = np.clip(_dot(from_corners, edges) / np.where(lengths > 0.0, lengths, 1.0), 0.0, 1.0)
    offsets = (
        from_corners[0] - share * edges[0],
        from_corners[1] - share * edges[1],
        from_corners[2] - share * edges[2],
    )
    squared[outside] = _dot(offsets, offsets).min(axis=0)
    return np.sqrt(squared), edge


_Vectors = tuple[Numbers, Numbers, Numbers]
"""The x, y and z of vectors, each of any one shape."""


def _picked(vectors: _Vectors, index: Any) -> _Vectors:
    return vectors[0][index], vectors[1][index], vectors[2][index]


def _dot(a: _Vectors, b: _Vectors) -> Numbers:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: _Vectors, b: _Vectors) -> _Vectors:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
