"""Upper bounds of the distances of many points from a surface, found by walking across its triangles."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure import even
from linkwright.stages.mesh.surfaces.neighbours import neighbours

Numbers = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_STEPS = 6
"""Triangles that a walk crosses: nearly all walks are over by then."""

_SAMPLES = 2_000, 10_000
"""Fewest and most points spread evenly over a surface."""

_PER_TRIANGLE = 4
"""Points for each triangle, between the fewest and the most: with more on small parts the error that is found
changes by a few percent."""


@dataclass(frozen=True, slots=True, eq=False)
class WalkedSurface:
    """A surface to walk on: the corners of its triangles (m, 3, 3), the triangle across each edge (m, 3),
    points spread evenly on it, and where walks begin: those points and the triangles' middles, with the
    triangle of each."""

    surface: Surface
    corners: Numbers
    across: Indices
    spread: Points
    starts: Any
    owners: Indices

    @staticmethod
    def of(surface: Surface) -> "WalkedSurface":
        # Late: a part from the cache needs no library that makes colliders or decimates.
        from scipy.spatial import cKDTree

        corners = surface.corners
        fewest, most = _SAMPLES
        spread = even(corners, min(max(_PER_TRIANGLE * len(corners), fewest), most))
        places = np.concatenate([spread.points, (corners[:, 0] + corners[:, 1] + corners[:, 2]) / 3])
        owners = np.concatenate([spread.triangles, np.arange(len(corners))])
        # A balanced tree takes four times as long to make, and is searched no faster.
        tree = cKDTree(places, balanced_tree=False, compact_nodes=False)
        return WalkedSurface(surface, corners, neighbours(surface), spread.points, tree, owners)

    def bounds(self, points: Points, enough: float) -> Numbers:
        """(n,): of each of the points (n, 3) a distance [m] that it has from the surface at most.

        A walk goes from the triangle of the nearest start to the one across the edge that the point is
        farthest beyond, until a triangle is within `enough` [m].
        """
        _, nearest = self.starts.query(points)
        triangles = self.owners[nearest]
        bound, edge = _reached(points, self.corners.take(triangles, axis=0))
        walking = np.arange(len(points))
        for _ in range(_STEPS):
            going = bound[walking] > enough
            walking, triangles, edge = walking[going], triangles[going], edge[going]
            if not len(walking):
                break
            triangles = self.across[triangles, edge]
            distance, edge = _reached(points.take(walking, axis=0), self.corners.take(triangles, axis=0))
            bound[walking] = np.minimum(bound[walking], distance)
        return bound


def _reached(points: Points, corners: Numbers) -> tuple[Numbers, npt.NDArray[np.intp]]:
    """(n,): the distance [m] of each of the points (n, 3) from its own triangle (n, 3, 3), and the edge that
    it is farthest beyond, seen along the triangle's normal.

    Of a triangle without area the distance is that of its edges. Coordinates are kept apart, in rows: NumPy
    is twice as fast so.
    """
    x, y, z = np.ascontiguousarray(corners.transpose(2, 1, 0))
    # Row k: from corner k, and from corner k to the next.
    here = points[:, 0] - x, points[:, 1] - y, points[:, 2] - z
    along = np.roll(x, -1, axis=0) - x, np.roll(y, -1, axis=0) - y, np.roll(z, -1, axis=0) - z
    normal = _cross(_picked(along, 0), _picked(along, 1))
    area = _dot(normal, normal)
    lengths = _dot(along, along)
    beyond = _dot(_cross(along, here), normal)
    edge = (beyond / np.sqrt(np.where(lengths > 0.0, lengths, 1.0))).argmin(axis=0)
    height = _dot(_picked(here, 0), normal)
    squared = height * height / np.where(area > 0.0, area, 1.0)
    beside = np.flatnonzero((beyond < 0.0).any(axis=0) | (area == 0.0))
    here, along, lengths = (
        _picked(here, np.s_[:, beside]),
        _picked(along, np.s_[:, beside]),
        lengths[:, beside],
    )
    share = np.clip(_dot(here, along) / np.where(lengths > 0.0, lengths, 1.0), 0.0, 1.0)
    off = here[0] - share * along[0], here[1] - share * along[1], here[2] - share * along[2]
    squared[beside] = _dot(off, off).min(axis=0)
    return np.sqrt(squared), edge


_Vectors = tuple[Numbers, Numbers, Numbers]
"""The x, y and z of vectors, each of any one shape."""


def _picked(vectors: _Vectors, which: Any) -> _Vectors:
    return vectors[0][which], vectors[1][which], vectors[2][which]


def _dot(a: _Vectors, b: _Vectors) -> Numbers:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: _Vectors, b: _Vectors) -> _Vectors:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
