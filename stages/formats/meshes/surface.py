"""Defines triangle surfaces as arrays: welding, figures, canonical order."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from linkwright.stages.formats.meshes.body_arrays import distinct
from linkwright.stages.formats.meshes.components import components

Points = npt.NDArray[np.float64]
"""Coordinates (n, 3) [m]."""
Triangles = npt.NDArray[np.int64]
"""Indices (m, 3) into the points, counter-clockwise seen from outside."""

_MERGE_DISTANCE = 1e-8  # m: the linear precision of the CAD kernel, which does not distinguish nearer points
_MERGE_SHARE = 1e-9  # numbers carry about 16 digits, and earlier steps lost some
_SKEW = (
    0.6404,
    0.5612,
    0.5243,
)  # a direction that is perpendicular to hardly any edge of a part; no longer than 1
_MAX_STEPS = 16
"""Number of neighbours along the line beyond which a tree is faster."""

_MAX_PACKED = 1 << 21  # three indices below this fit in a number of 64 bits
_MAX_MERGE_SHARE = 1e-3  # so that even a tiny surface keeps its shape

_NO_NORMAL = np.array([0.0, 0.0, 1.0])  # the normal of a triangle without area


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles over points.

    Both sides of a seam of a texture share points: only corners have (u, v).
    """

    vertices: Points
    """(n, 3) [m]."""

    triangles: Triangles
    """(m, 3), indices into `vertices`."""

    texcoords: npt.NDArray[np.float32] | None = None
    """(m, 3, 2): (u, v) of each corner in an image, whose lower left corner is (0, 0); None without a
    texture."""

    @property
    def corners(self) -> npt.NDArray[np.float64]:
        """Returns the three corners of each triangle (m, 3, 3)."""
        # `take` is four times as fast as an index.
        return self.vertices.take(self.triangles, axis=0)

    @property
    def diagonal(self) -> float:
        """Returns the diagonal [m] of the box around the points; 0 without points."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0))) if len(self.vertices) else 0.0

    def flipped(self) -> "Surface":
        """Returns the same surface, turned inside out."""
        texcoords = None if self.texcoords is None else self.texcoords[:, ::-1]
        return Surface(self.vertices, self.triangles[:, ::-1], texcoords)

    def normals(self) -> npt.NDArray[np.float64]:
        """Returns the normal of each triangle (m, 3), whose length is twice its area [m²]."""
        a, b, c = self.vertices[self.triangles.T]
        return _cross(b - a, c - a)

    def area(self) -> float:
        """Returns the area [m²]."""
        return float(np.linalg.norm(self.normals(), axis=1).sum() / 2)

    def closed(self) -> bool:
        """Tells whether every edge occurs equally often in both directions."""
        starts, ends = self.triangles.ravel(), self.triangles[:, (1, 2, 0)].ravel()
        count = np.int64(len(self.vertices))
        up, down = starts < ends, starts > ends
        forth, back = starts[up] * count + ends[up], ends[down] * count + starts[down]
        return bool(len(starts)) and np.array_equal(np.sort(forth), np.sort(back))

    def cone_volumes(self, apex: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Returns the signed volume [m³] of each triangle's cone from `apex` (3,), as (m,)."""
        a, b, c = (self.vertices - apex)[self.triangles.T]
        volumes: npt.NDArray[np.float64] = np.einsum("ij,ij->i", a, _cross(b, c)) / 6
        return volumes

    def volume(self) -> float:
        """Returns the volume inside [m³], negative for a surface that is inside out; 0 for an open
        surface."""
        if not self.closed():
            return 0.0
        # About a point near by, since far from the origin the cones cancel badly.
        return float(self.cone_volumes(self.vertices.mean(axis=0)).sum())


def weld(
    points: Points, triangles: Triangles, texcoords: npt.NDArray[np.float32] | None = None
) -> tuple[Surface, npt.NDArray[np.int64]]:
    """Makes a surface from loose triangles, in canonical order; returns it with the triangles that it kept.

    Points nearer than 1e-8 m, or than 1e-9 of the size if that is more, are merged. Triangles that lose a
    corner by this are dropped; slivers stay, since their neighbours need their edges. Points are sorted
    lexicographically, triangles by their points, so that the order of the input does not matter. The second
    value (m,) has the index of each triangle in the input.
    """
    is_used, compact = _used(len(points), triangles)
    vertices, vertex_of = _nearly_distinct(points[is_used])
    corners = vertex_of[compact]
    kept = np.flatnonzero(
        (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 2] != corners[:, 0])
    )
    corners = corners[kept]
    first = corners.argmin(axis=1)[:, None]
    turn = (first + np.arange(3)) % 3
    corners = np.take_along_axis(corners, turn, axis=1)
    order = _order(corners, len(vertices))
    if texcoords is not None:
        texcoords = np.take_along_axis(texcoords[kept], turn[:, :, None], axis=1)[order]
    return Surface(vertices, corners.take(order, axis=0), texcoords), kept[order]


def _order(corners: Triangles, count: int) -> npt.NDArray[np.intp]:
    """Returns the lexicographical order of triangles over `count` points; equal triangles stay in their
    order."""
    a, b, c = np.ascontiguousarray(corners.T)
    if count <= _MAX_PACKED:
        # A sort that need not keep the order of equal keys takes a quarter of the time.
        keys = (a * count + b) * count + c
        order = np.argsort(keys)
        ordered = keys[order]
        if (ordered[1:] != ordered[:-1]).all():
            return order
    return np.lexsort((c, b, a))


def joined(surfaces: Sequence[Surface]) -> Surface:
    """Joins surfaces, each with its own points."""
    offsets = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    triangles = [surface.triangles + offset for surface, offset in zip(surfaces, offsets, strict=False)]
    texcoords = None
    if any(surface.texcoords is not None for surface in surfaces):
        texcoords = np.concatenate([_texcoords(surface) for surface in surfaces])
    vertices = np.concatenate([surface.vertices for surface in surfaces])
    return Surface(vertices, np.concatenate(triangles), texcoords)


def chosen(surface: Surface, faces: npt.NDArray[Any]) -> Surface:
    """Returns some triangles of a surface, by number or by mask, and only their points."""
    texcoords = None if surface.texcoords is None else surface.texcoords[faces]
    return compacted(Surface(surface.vertices, surface.triangles[faces], texcoords))


def rounded(surface: Surface) -> Surface:
    """Returns the surface in the single precision of a file: welded again, without degenerate triangles."""
    vertices, vertex_of = distinct(surface.vertices.astype(np.float32).astype(np.float64))
    corners = vertex_of[surface.triangles]
    a, b, c = corners.T
    return chosen(Surface(vertices, corners, surface.texcoords), (a != b) & (b != c) & (c != a))


def compacted(surface: Surface) -> Surface:
    """Returns the surface without unused points."""
    is_used, corners = _used(len(surface.vertices), surface.triangles)
    return Surface(surface.vertices[is_used], corners, surface.texcoords)


def moved(surface: Surface, transform: npt.NDArray[np.float64]) -> Surface:
    """Returns the surface under `transform` (4, 4); under a mirroring transform the outside stays outside.

    Written out by element: a matrix product may round differently from one processor to the next.
    """
    x, y, z = surface.vertices.T
    vertices = np.stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in transform[:3]], axis=1)
    result = Surface(vertices + 0.0, surface.triangles, surface.texcoords)
    return result.flipped() if np.linalg.det(transform[:3, :3]) < 0 else result


def _used(count: int, triangles: Triangles) -> tuple[npt.NDArray[np.bool_], Triangles]:
    """Returns whether the triangles use each of `count` points, and the triangles over the used points."""
    is_used = np.zeros(count, dtype=bool)
    is_used[triangles] = True
    return is_used, (np.cumsum(is_used) - 1)[triangles]


def _texcoords(surface: Surface) -> npt.NDArray[np.float32]:
    if surface.texcoords is None:
        return np.zeros((len(surface.triangles), 3, 2), dtype=np.float32)
    return surface.texcoords


def unit(vectors: Points) -> Points:
    """Returns the vectors (m, 3) with length 1; along z instead of a vector without length, since readers
    need unit normals."""
    # Written out by element: a matrix product may round differently from one processor to the next.
    x, y, z = vectors.T
    lengths = np.sqrt(x * x + y * y + z * z)[:, None]
    result: Points = np.divide(
        vectors, lengths, out=np.tile(_NO_NORMAL, (len(vectors), 1)), where=lengths > 0
    )
    return result


def _cross(first: Points, second: Points) -> Points:
    """Returns the cross product of each pair of rows (m, 3), as `np.cross`, which takes twice as long for
    some hundred rows."""
    (a, b, c), (u, v, w) = first.T, second.T
    return np.stack([b * w - c * v, c * u - a * w, a * v - b * u], axis=1)


def _nearly_distinct(points: Points) -> tuple[Points, npt.NDArray[np.int64]]:
    """Returns distinct points and indices as `distinct`, with near points merged into the first of them."""
    vertices, index = distinct(points)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0))) if len(vertices) else 0.0
    pairs = _near_pairs(vertices, _tolerance(size))
    if not len(pairs):
        return vertices, index

    group = components(len(vertices), pairs[:, 0], pairs[:, 1])
    # Each group is the first of its points, so that groups stay sorted as the points are.
    leaders = np.unique(group, return_index=True)[1]
    return vertices[leaders], group[index]


def _near_pairs(points: Points, reach: float) -> npt.NDArray[np.int64]:
    """Returns the pairs (k, 2) of points (n, 3) that are at most `reach` [m] apart.

    Near points are also near along a skew line, and few other points are: sorting along the line takes a
    tenth of the time of a tree.
    """
    along = points[:, 0] * _SKEW[0] + points[:, 1] * _SKEW[1] + points[:, 2] * _SKEW[2]
    order = np.argsort(along, kind="stable")
    along = along[order]
    # Places along the line are rounded.
    reach_along = reach + 8 * float(np.spacing(np.abs(points).max(initial=0.0)))
    near_pairs = []
    for step in range(1, len(points)):
        first = np.flatnonzero(along[step:] - along[:-step] <= reach_along)
        if not len(first):
            break
        if step > _MAX_STEPS:
            pairs = scipy.spatial.cKDTree(points).query_pairs(reach, output_type="ndarray")
            return np.asarray(pairs, dtype=np.int64)
        pairs = np.stack([order[first], order[first + step]], axis=1)
        difference = points[pairs[:, 0]] - points[pairs[:, 1]]
        near_pairs.append(pairs[np.sqrt((difference * difference).sum(axis=1)) <= reach])
    return np.concatenate(near_pairs) if near_pairs else np.zeros((0, 2), dtype=np.int64)


def _tolerance(size: float) -> float:
    """Returns the distance [m] below which points of a surface that is `size` [m] across are merged."""
    return min(max(_MERGE_DISTANCE, _MERGE_SHARE * size), _MAX_MERGE_SHARE * size)
