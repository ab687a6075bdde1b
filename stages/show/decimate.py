"""A surface with fewer triangles, its colours and the borders between them kept together.

manifold3d and not fast-simplification, by measurement: of CAD's long thin triangles the second one leaves
three to five times as many, and moves the surface two to eight times as far. manifold3d takes closed
manifolds only: every other mesh is cut along its bad edges, and each border is closed by a cone of
triangles, which is left out again.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface, Triangles, weld

if TYPE_CHECKING:
    from manifold3d import Manifold

SNAP = 1e-6
"""Coordinates are multiples of this share of the part's diagonal: the last digits of a simplification may
differ from one processor to the next."""

_MIRROR = np.array([1, 2, 0])

_LEFT = 0.7
"""The share of triangles that a level leaves of those of the level below, as a rule."""


@dataclass(frozen=True, slots=True, eq=False)
class Simplifiable:
    """A surface as a manifold, from which surfaces of any tolerance are made; `body` is None where it cannot
    be simplified. `colours`: how many colours it has; `first`: the number that the manifold has for the first
    of them, which the others follow."""

    surface: Surface
    colours: int
    body: "Manifold | None"
    first: int = 0

    @staticmethod
    def of(surface: Surface, colour_of: npt.NDArray[np.int64], colours: int = 1) -> "Simplifiable":
        """`colour_of` (m,): the colour of each triangle, below `colours`."""
        # Late: a part from the cache needs no library that makes colliders or decimates.
        from manifold3d import Error, Manifold, Mesh64

        points, triangles, sources = _closed(surface)
        # A run of triangles for each colour: an edge between two runs moves along its own line only.
        runs = np.where(sources < 0, colours, colour_of[sources])
        order = np.argsort(runs, kind="stable")
        bounds = np.searchsorted(runs[order], np.arange(colours + 2))
        first = Manifold.reserve_ids(colours + 1)
        body = Manifold(
            Mesh64(
                points,
                triangles[order].astype(np.uint64),
                run_index=(bounds * 3).astype(np.uint64),
                run_original_id=np.arange(first, first + colours + 1, dtype=np.uint32),
            )
        )
        return Simplifiable(surface, colours, body if body.status() == Error.NoError else None, first)

    def simplified(self, tolerance: float) -> tuple[Surface, npt.NDArray[np.int64]] | None:
        """The surface, moved by about `tolerance` [m] at most, and the colour of each of its triangles; None
        where it cannot be simplified.

        A border between two colours is one line for both before and after.
        """
        if self.body is None:
            return None
        found = self.body.simplify(tolerance).to_mesh64()
        corners = np.asarray(found.tri_verts).astype(np.int64).reshape(-1, 3)
        ends = np.asarray(found.run_index, dtype=np.int64)
        lengths = (ends[1:] - ends[:-1]) // 3
        colours = np.repeat(np.asarray(found.run_original_id).astype(np.int64) - self.first, lengths)
        seen = np.flatnonzero(colours < self.colours)
        vertices = _snapped(np.asarray(found.vert_properties, dtype=np.float64)[:, :3], self.surface)
        surface, kept = weld(vertices, corners[seen])
        return (surface, colours[seen][kept]) if len(surface.triangles) else None


def _snapped(points: Points, like: Surface) -> Points:
    step = SNAP * float(np.linalg.norm(np.ptp(like.vertices, axis=0)))
    return np.asarray(np.round(points / step) * step + 0.0, dtype=np.float64) if step else points


def _closed(surface: Surface) -> tuple[Points, Triangles, npt.NDArray[np.int64]]:
    """Points and triangles of a manifold without border that contains the surface, and for each triangle
    the one that it is in the surface, -1 for those that close a border."""
    if _is_manifold(surface):
        return surface.vertices, surface.triangles, np.arange(len(surface.triangles))
    corner, border = _cut(surface)
    points = np.empty((int(corner.max()) + 1, 3))
    points[corner.ravel()] = surface.corners.reshape(-1, 3)
    own = np.arange(len(corner))
    if not len(border):
        return points, corner, own
    apexes, loop = _apexes(points, border, surface)
    cones = np.stack([border[:, 1], border[:, 0], len(points) + loop], axis=1)
    sources = np.concatenate([own, np.full(len(cones), -1)])
    return np.concatenate([points, apexes]), np.concatenate([corner, cones]), sources


def _is_manifold(surface: Surface) -> bool:
    """Whether each edge has one triangle on either side."""
    starts, ends = surface.triangles.ravel(), surface.triangles[:, _MIRROR].ravel()
    count = np.int64(len(surface.vertices))
    forth, back = np.sort(starts * count + ends), np.sort(ends * count + starts)
    return np.array_equal(forth, back) and bool((forth[1:] > forth[:-1]).all())


def _cut(surface: Surface) -> tuple[Triangles, Triangles]:
    """The triangles with a vertex of its own for each fan of triangles around a point, and the edges (k, 2)
    of its border: a triangle goes on across an edge only where exactly one other one runs through it the
    other way."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    starts = surface.triangles.ravel()
    ends = surface.triangles[:, _MIRROR].ravel()
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    order = np.lexsort((starts, high, low))
    key = np.stack([low[order], high[order]], axis=1)
    new = np.ones(len(key), dtype=bool)
    new[1:] = (key[1:] != key[:-1]).any(axis=1)
    begins = np.flatnonzero(new)
    pairs = begins[np.diff(np.append(begins, len(key))) == 2]
    one, other = order[pairs], order[pairs + 1]
    opposite = starts[one] != starts[other]
    one, other = one[opposite], other[opposite]
    # Half edge i leaves corner i of the flat list of triangles, and ends at the next corner of its triangle.
    following = np.arange(len(starts)).reshape(-1, 3)[:, _MIRROR].ravel()
    links = np.concatenate([one, following[one]]), np.concatenate([following[other], other])
    ones = np.ones(len(links[0]), dtype=np.int8)
    _, label = connected_components(coo_array((ones, links), (len(starts), len(starts))), directed=False)
    alone = np.ones(len(starts), dtype=bool)
    alone[one] = alone[other] = False
    corner = label.astype(np.int64).reshape(-1, 3)
    return corner, np.stack([label[alone], label[following[alone]]], axis=1).astype(np.int64)


def _apexes(points: Points, border: Triangles, surface: Surface) -> tuple[Points, npt.NDArray[np.int64]]:
    """A point beside each loop of the border, as far away as the surface is large; the loop of each edge."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    used, compact = np.unique(border, return_inverse=True)
    compact = compact.reshape(-1, 2)
    ones = np.ones(len(border), dtype=np.int8)
    count, label = connected_components(
        coo_array((ones, (compact[:, 0], compact[:, 1])), (len(used), len(used))), directed=False
    )
    loop = label[compact[:, 0]].astype(np.int64)
    weights = np.bincount(loop, minlength=count)[:, None]
    middles = np.stack(
        [np.bincount(loop, points[border[:, 0], axis], minlength=count) for axis in range(3)], axis=1
    )
    crossed = np.cross(points[border[:, 0]], points[border[:, 1]])
    normals = np.stack([np.bincount(loop, crossed[:, axis], minlength=count) for axis in range(3)], axis=1)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    upright = np.where(lengths > 0, normals / np.where(lengths > 0, lengths, 1.0), [0.0, 0.0, 1.0])
    size = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    return middles / weights + size * upright, loop


def lowest(levels: int, faces: Callable[[int], int], most: int, first: int | None = None) -> int:
    """The lowest level with at most so many faces, `levels` where none has; higher levels have no more.
    `first`: the level that is tried first, by default the middle."""
    low, high, level = 0, levels, levels // 2 if first is None else first
    while low < high:
        count = faces(level)
        if count <= most:
            high = level
        else:
            low = level + 1
        # Each level takes a while: the next one is where the number is likely to be reached.
        further = math.log(max(count, 1) / max(most, 1)) / math.log(1 / _LEFT)
        level = min(max(level + math.ceil(further), low), high - 1)
    return low
