"""Defines triangle surfaces as arrays, with their measures, and welds loose triangles in canonical order."""

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

_MERGE_DISTANCE = 1e-8
"""Distance [m] up to which points are merged: the linear precision of the CAD kernel."""

_MERGE_SHARE = 1e-9
"""Distance up to which points are merged, as a share of the surface's size, for large surfaces: numbers have
about 16 digits, and earlier steps lost some."""

_MAX_MERGE_SHARE = 1e-3
"""Largest distance of merged points as a share of the size, so that even a tiny surface keeps its shape."""

_SKEW_DIRECTION = (0.6404, 0.5612, 0.5243)
"""A direction that is perpendicular to hardly any edge of a part; no longer than 1, so that points are never
farther apart along it than in space."""

_MAX_NEIGHBOURS = 16
"""Number of near points along the skew direction beyond which a tree is faster."""

_MAX_PACKED_POINTS = 1 << 21
"""Number of points up to which three indices fit in an integer of 64 bits."""

_DEFAULT_NORMAL = np.array([0.0, 0.0, 1.0])
"""The normal of a triangle without area."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles over points that they share.

    The triangles on both sides of a texture's seam share points too, since (u, v) belong to corners.
    """

    vertices: Points
    """(n, 3) [m]."""

    triangles: Triangles
    """(m, 3), indices into `vertices`."""

    texcoords: npt.NDArray[np.float32] | None = None
    """(m, 3, 2), the (u, v) of each corner; (0, 0) is the lower left corner of the image. None without a
    texture."""

    @property
    def corners(self) -> npt.NDArray[np.float64]:
        """The three corners of each triangle (m, 3, 3) [m]."""
        # `take` is four times as fast as indexing.
        return self.vertices.take(self.triangles, axis=0)

    @property
    def diagonal(self) -> float:
        """The diagonal [m] of the box around the points, along the axes; 0 without points."""
        return _box_diagonal(self.vertices)

    def flipped(self) -> "Surface":
        """Returns the same surface, turned inside out."""
        texcoords = None if self.texcoords is None else self.texcoords[:, ::-1]
        return Surface(self.vertices, self.triangles[:, ::-1], texcoords)

    def normals(self) -> npt.NDArray[np.float64]:
        """Returns the normal of each triangle (m, 3); its length is twice the triangle's area [m²]."""
        a, b, c = self.vertices[self.triangles.T]
        return _cross(b - a, c - a)

    def area(self) -> float:
        """Returns the area [m²]."""
        return float(np.linalg.norm(self.normals(), axis=1).sum() / 2)

    def is_closed(self) -> bool:
        """Tells whether there are triangles, and every edge occurs equally often in both directions."""
        starts, ends = self.triangles.ravel(), self.triangles[:, (1, 2, 0)].ravel()
        # Each edge is a number, made of its lower and its higher index.
        point_count = np.int64(len(self.vertices))
        rises, falls = starts < ends, starts > ends
        rising_edges = starts[rises] * point_count + ends[rises]
        falling_edges = ends[falls] * point_count + starts[falls]
        return bool(len(starts)) and np.array_equal(np.sort(rising_edges), np.sort(falling_edges))

    def cone_volumes(self, apex: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Returns the signed volume [m³] (m,) of the cone between each triangle and `apex` (3,)."""
        a, b, c = (self.vertices - apex)[self.triangles.T]
        volumes: npt.NDArray[np.float64] = np.einsum("ij,ij->i", a, _cross(b, c)) / 6
        return volumes

    def volume(self) -> float:
        """Returns the volume [m³] inside the surface; negative if it is inside out, 0 if it is open."""
        if not self.is_closed():
            return 0.0
        # From a near point: from a distant one, large volumes of opposite signs would cancel.
        return float(self.cone_volumes(self.vertices.mean(axis=0)).sum())


def weld(
    points: Points, triangles: Triangles, texcoords: npt.NDArray[np.float32] | None = None
) -> tuple[Surface, npt.NDArray[np.int64]]:
    """Makes a surface of loose triangles, in canonical order; returns it, and the index (k,) in `triangles`
    of each of its triangles.

    Points nearer than 1e-8 m, or than 1e-9 of the size if that is more, are merged. Triangles that lose a
    corner by this are dropped; slivers stay, since their neighbours need their edges. Points are sorted
    lexicographically, and triangles by their points, so that the order of the input does not matter.
    """
    is_used, compact_triangles = _compact_indices(len(points), triangles)
    vertices, vertex_of = _merge_near_points(points[is_used])
    corners = vertex_of[compact_triangles]
    complete_triangles = np.flatnonzero(_has_distinct_corners(corners))
    corners = corners[complete_triangles]
    # Each triangle begins at its first point.
    start = corners.argmin(axis=1)[:, None]
    cyclic_order = (start + np.arange(3)) % 3
    corners = np.take_along_axis(corners, cyclic_order, axis=1)
    order = _triangle_order(corners, len(vertices))
    if texcoords is not None:
        texcoords = np.take_along_axis(texcoords[complete_triangles], cyclic_order[:, :, None], axis=1)[order]
    return Surface(vertices, corners.take(order, axis=0), texcoords), complete_triangles[order]


def _has_distinct_corners(triangles: Triangles) -> npt.NDArray[np.bool_]:
    """Tells for each triangle (m,) whether its three corners are distinct points."""
    a, b, c = triangles.T
    distinct_corners: npt.NDArray[np.bool_] = (a != b) & (b != c) & (c != a)
    return distinct_corners


def _triangle_order(triangles: Triangles, point_count: int) -> npt.NDArray[np.intp]:
    """Returns the lexicographical order of triangles; equal triangles stay in their order."""
    a, b, c = np.ascontiguousarray(triangles.T)
    if point_count <= _MAX_PACKED_POINTS:
        # A sort that need not keep the order of equal keys takes a quarter of the time.
        keys = (a * point_count + b) * point_count + c
        order = np.argsort(keys)
        ordered = keys[order]
        if (ordered[1:] != ordered[:-1]).all():
            return order
    return np.lexsort((c, b, a))


def join_surfaces(surfaces: Sequence[Surface]) -> Surface:
    """Returns the surfaces as a single surface, in which each keeps its own points."""
    offsets = np.cumsum([0, *(len(surface.vertices) for surface in surfaces[:-1])])
    triangles = [surface.triangles + offset for surface, offset in zip(surfaces, offsets, strict=True)]
    texcoords = None
    if any(surface.texcoords is not None for surface in surfaces):
        texcoords = np.concatenate([_texcoords_or_zeros(surface) for surface in surfaces])
    vertices = np.concatenate([surface.vertices for surface in surfaces])
    return Surface(vertices, np.concatenate(triangles), texcoords)


def select_triangles(surface: Surface, selection: npt.NDArray[Any]) -> Surface:
    """Returns the triangles that `selection` names by index or by a mask, with only their points."""
    texcoords = None if surface.texcoords is None else surface.texcoords[selection]
    return drop_unused_points(Surface(surface.vertices, surface.triangles[selection], texcoords))


def round_to_single(surface: Surface) -> Surface:
    """Returns the surface with coordinates in single precision, as files have them. Points that become equal
    are merged, and triangles that lose a corner by this are dropped."""
    vertices, vertex_of = distinct(surface.vertices.astype(np.float32).astype(np.float64))
    corners = vertex_of[surface.triangles]
    return select_triangles(Surface(vertices, corners, surface.texcoords), _has_distinct_corners(corners))


def drop_unused_points(surface: Surface) -> Surface:
    """Returns the surface without unused points."""
    is_used, triangles = _compact_indices(len(surface.vertices), surface.triangles)
    return Surface(surface.vertices[is_used], triangles, surface.texcoords)


def transform_surface(surface: Surface, transform: npt.NDArray[np.float64]) -> Surface:
    """Returns the surface, moved by `transform` (4, 4). If that reflects, the triangles are flipped, so that
    the outside stays outside."""
    # Written out by element: a matrix product may round differently from one processor to the next.
    x, y, z = surface.vertices.T
    vertices = np.stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in transform[:3]], axis=1)
    # + 0.0 makes −0 a 0.
    transformed = Surface(vertices + 0.0, surface.triangles, surface.texcoords)
    return transformed.flipped() if np.linalg.det(transform[:3, :3]) < 0 else transformed


def _compact_indices(point_count: int, triangles: Triangles) -> tuple[npt.NDArray[np.bool_], Triangles]:
    """Returns a mask (point_count,) of the points that triangles use, and the triangles as indices into these
    points alone."""
    is_used = np.zeros(point_count, dtype=bool)
    is_used[triangles] = True
    return is_used, (np.cumsum(is_used) - 1)[triangles]


def _box_diagonal(points: Points) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0


def _texcoords_or_zeros(surface: Surface) -> npt.NDArray[np.float32]:
    if surface.texcoords is None:
        return np.zeros((len(surface.triangles), 3, 2), dtype=np.float32)
    return surface.texcoords


def unit_vectors(vectors: Points) -> Points:
    """Returns the vectors (m, 3), scaled to length 1; a vector without length becomes z, since readers of
    files expect unit normals."""
    # Written out by element: a matrix product may round differently from one processor to the next.
    x, y, z = vectors.T
    lengths = np.sqrt(x * x + y * y + z * z)[:, None]
    default_normals = np.tile(_DEFAULT_NORMAL, (len(vectors), 1))
    units: Points = np.divide(vectors, lengths, out=default_normals, where=lengths > 0)
    return units


def _cross(first: Points, second: Points) -> Points:
    """Returns the cross product of each pair of rows (m, 3). `np.cross` takes twice as long for some hundred
    rows."""
    (a, b, c), (u, v, w) = first.T, second.T
    return np.stack([b * w - c * v, c * u - a * w, a * v - b * u], axis=1)


def _merge_near_points(points: Points) -> tuple[Points, npt.NDArray[np.int64]]:
    """Returns distinct points, sorted, and the index of each of `points` among them. Each group of near
    points is merged into the first of them."""
    vertices, vertex_of = distinct(points)
    pairs = _near_pairs(vertices, _merge_tolerance(_box_diagonal(vertices)))
    if not len(pairs):
        return vertices, vertex_of

    # Groups are numbered in the order of their first points, so that they stay sorted as the points are.
    group_of = components(len(vertices), pairs[:, 0], pairs[:, 1])
    first_points = np.unique(group_of, return_index=True)[1]
    return vertices[first_points], group_of[vertex_of]


def _near_pairs(points: Points, reach: float) -> npt.NDArray[np.int64]:
    """Returns the pairs (k, 2) of points (n, 3), as indices, that are at most `reach` [m] apart.

    Near points are also near along a skew line, and few other points are: sorting along the line takes a
    tenth of the time of a tree.
    """
    x, y, z = _SKEW_DIRECTION
    position = points[:, 0] * x + points[:, 1] * y + points[:, 2] * z
    order = np.argsort(position, kind="stable")
    position = position[order]
    # Some units in the last place more, since positions are rounded.
    reach_along_line = reach + 8 * float(np.spacing(np.abs(points).max(initial=0.0)))
    near_pairs = []
    for step in range(1, len(points)):
        # Indices in the order along the line of the points whose `step`-th successor is near.
        first = np.flatnonzero(position[step:] - position[:-step] <= reach_along_line)
        if not len(first):
            break
        if step > _MAX_NEIGHBOURS:
            pairs = scipy.spatial.cKDTree(points).query_pairs(reach, output_type="ndarray")
            return np.asarray(pairs, dtype=np.int64)
        pairs = np.stack([order[first], order[first + step]], axis=1)
        difference = points[pairs[:, 0]] - points[pairs[:, 1]]
        near_pairs.append(pairs[np.sqrt((difference * difference).sum(axis=1)) <= reach])
    return np.concatenate(near_pairs) if near_pairs else np.zeros((0, 2), dtype=np.int64)


def _merge_tolerance(size: float) -> float:
    """Returns the distance [m] up to which points are merged; `size` [m]: the diagonal of the box around
    them."""
    return min(max(_MERGE_DISTANCE, _MERGE_SHARE * size), _MAX_MERGE_SHARE * size)
