"""Triangle surfaces as arrays: welding, figures, canonical order."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.triangles import distinct

Points = npt.NDArray[np.float64]
"""(n, 3) coordinates [m]."""
Triangles = npt.NDArray[np.int64]
"""(m, 3) indices into the points, counter-clockwise seen from outside."""

_SAME = 1e-8  # m: the linear precision of the CAD kernel, which does not distinguish nearer points
_SAME_OF_SIZE = 1e-9  # numbers carry about 16 digits, and earlier steps lost some
_SKEW = 0.6404, 0.5612, 0.5243  # a direction that hardly an edge of a part is across; no longer than 1
_MOST_STEPS = 16
_PACKED = 1 << 21  # three numbers of so many points fit in one of 64 bits
_LEAST_OF_SIZE = 1e-3  # however small, a surface keeps its shape


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles over points. `vertices` (n, 3) [m]; `triangles` (m, 3). `texcoords` (m, 3, 2): (u, v) of each
    corner in an image, whose lower left corner is (0, 0); None without a texture.

    Points are one on either side of a seam of a texture: only corners have (u, v).
    """

    vertices: Points
    triangles: Triangles
    texcoords: npt.NDArray[np.float32] | None = None

    @property
    def corners(self) -> npt.NDArray[np.float64]:
        """(m, 3, 3): the three corners of each triangle."""
        # `take` is four times as fast as an index.
        return self.vertices.take(self.triangles, axis=0)

    @property
    def diagonal(self) -> float:
        """The diagonal [m] of the box around the points; 0 without any."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0))) if len(self.vertices) else 0.0

    def flipped(self) -> "Surface":
        """The same surface with its inside out."""
        texcoords = None if self.texcoords is None else self.texcoords[:, ::-1]
        return Surface(self.vertices, self.triangles[:, ::-1], texcoords)

    def normals(self) -> npt.NDArray[np.float64]:
        """(m, 3): the normal of each triangle, twice its area long [m²]."""
        a, b, c = self.vertices[self.triangles.T]
        return _cross(b - a, c - a)

    def area(self) -> float:
        """The area [m²]."""
        return float(np.linalg.norm(self.normals(), axis=1).sum() / 2)

    def closed(self) -> bool:
        """Whether every edge is run through as often in one sense as in the other."""
        starts, ends = self.triangles.ravel(), self.triangles[:, (1, 2, 0)].ravel()
        count = np.int64(len(self.vertices))
        up, down = starts < ends, starts > ends
        forth, back = starts[up] * count + ends[up], ends[down] * count + starts[down]
        return bool(len(starts)) and np.array_equal(np.sort(forth), np.sort(back))

    def cone_volumes(self, apex: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """(m,): signed volume [m³] of each triangle's cone from `apex` (3,)."""
        a, b, c = (self.vertices - apex)[self.triangles.T]
        volumes: npt.NDArray[np.float64] = np.einsum("ij,ij->i", a, _cross(b, c)) / 6
        return volumes

    def volume(self) -> float:
        """The volume inside [m³], negative where inside out; 0 where the surface is not closed."""
        if not self.closed():
            return 0.0
        # About a point near by, since far from the origin the cones cancel badly.
        return float(self.cone_volumes(self.vertices.mean(axis=0)).sum())


def weld(
    points: Points, triangles: Triangles, texcoords: npt.NDArray[np.float32] | None = None
) -> tuple[Surface, npt.NDArray[np.int64]]:
    """One surface out of loose triangles, in canonical order, and which triangles it kept.

    Points nearer than 1e-8 m, or than 1e-9 of the size where that is more, become one. Triangles
    that lose a corner so are dropped; slivers stay, since their neighbours need their edges. Points
    are sorted lexicographically, triangles by their points, so that the order of the input does not
    matter. The second value (m,) has the index of each triangle in the input.
    """
    used, compact = _used(len(points), triangles)
    vertices, merged = _nearly_distinct(points[used])
    corners = merged[compact]
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
    """The lexicographical order of triangles over `count` points; of equal ones as they come."""
    a, b, c = np.ascontiguousarray(corners.T)
    if count <= _PACKED:
        # A sort that need not keep the order of equal keys takes a quarter of the time.
        keys = (a * count + b) * count + c
        order = np.argsort(keys)
        ordered = keys[order]
        if (ordered[1:] != ordered[:-1]).all():
            return order
    return np.lexsort((c, b, a))


def joined(surfaces: Sequence[Surface]) -> Surface:
    """Several surfaces as one, each with its own points."""
    offsets = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    triangles = [surface.triangles + offset for surface, offset in zip(surfaces, offsets, strict=False)]
    texcoords = None
    if any(surface.texcoords is not None for surface in surfaces):
        texcoords = np.concatenate([_texcoords(surface) for surface in surfaces])
    vertices = np.concatenate([surface.vertices for surface in surfaces])
    return Surface(vertices, np.concatenate(triangles), texcoords)


def chosen(surface: Surface, faces: npt.NDArray[Any]) -> Surface:
    """Some triangles of a surface, by number or by mask, and no other points."""
    texcoords = None if surface.texcoords is None else surface.texcoords[faces]
    return compacted(Surface(surface.vertices, surface.triangles[faces], texcoords))


def rounded(surface: Surface) -> Surface:
    """The surface as a file with single precision has it: welded again, degenerate triangles gone."""
    vertices, merged = distinct(surface.vertices.astype(np.float32).astype(np.float64))
    corners = merged[surface.triangles]
    a, b, c = corners.T
    return chosen(Surface(vertices, corners, surface.texcoords), (a != b) & (b != c) & (c != a))


def compacted(surface: Surface) -> Surface:
    """The surface without the points that no triangle has."""
    used, corners = _used(len(surface.vertices), surface.triangles)
    return Surface(surface.vertices[used], corners, surface.texcoords)


def moved(surface: Surface, transform: npt.NDArray[np.float64]) -> Surface:
    """The surface under `transform` (4, 4); a mirroring one keeps the outside outside.

    Written out by element: a matrix product may round differently from one processor to the next.
    """
    x, y, z = surface.vertices.T
    vertices = np.stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in transform[:3]], axis=1)
    result = Surface(vertices + 0.0, surface.triangles, surface.texcoords)
    return result.flipped() if np.linalg.det(transform[:3, :3]) < 0 else result


def _used(count: int, triangles: Triangles) -> tuple[npt.NDArray[np.bool_], Triangles]:
    """Which of `count` points the triangles have, and the triangles over those alone."""
    used = np.zeros(count, dtype=bool)
    used[triangles] = True
    return used, (np.cumsum(used) - 1)[triangles]


def _texcoords(surface: Surface) -> npt.NDArray[np.float32]:
    if surface.texcoords is None:
        return np.zeros((len(surface.triangles), 3, 2), dtype=np.float32)
    return surface.texcoords


def _cross(one: Points, other: Points) -> Points:
    """(m, 3): the cross product of each pair of rows, as `np.cross`, which takes twice as long for some
    hundred rows."""
    (a, b, c), (u, v, w) = one.T, other.T
    return np.stack([b * w - c * v, c * u - a * w, a * v - b * u], axis=1)


def _nearly_distinct(points: Points) -> tuple[Points, npt.NDArray[np.int64]]:
    """As `distinct`, but points that are near to each other count as one: the first of them."""
    vertices, index = distinct(points)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0))) if len(vertices) else 0.0
    pairs = _near_pairs(vertices, _tolerance(size))
    if not len(pairs):
        return vertices, index
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(vertices)
    links = coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), (count, count))
    _, group = connected_components(links, directed=False)
    # Each group is the first of its points, so that groups stay sorted as the points are.
    _, leaders, member = np.unique(group, return_index=True, return_inverse=True)
    order = np.argsort(leaders)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return vertices[leaders[order]], rank[member.ravel()][index]


def _near_pairs(points: Points, reach: float) -> npt.NDArray[np.int64]:
    """(k, 2): the pairs of points (n, 3) that are at most `reach` [m] apart.

    Along a skew line near points are near too, and few others are: that takes a tenth of the time of a tree.
    """
    along = points[:, 0] * _SKEW[0] + points[:, 1] * _SKEW[1] + points[:, 2] * _SKEW[2]
    order = np.argsort(along, kind="stable")
    along = along[order]
    # Places along the line are rounded.
    reach_along = reach + 8 * float(np.spacing(np.abs(points).max(initial=0.0)))
    found = []
    for step in range(1, len(points)):
        first = np.flatnonzero(along[step:] - along[:-step] <= reach_along)
        if not len(first):
            break
        if step > _MOST_STEPS:
            # Late: a part from the cache needs no library that makes colliders or decimates.
            from scipy.spatial import cKDTree

            pairs = cKDTree(points).query_pairs(reach, output_type="ndarray")
            return np.asarray(pairs, dtype=np.int64)
        pairs = np.stack([order[first], order[first + step]], axis=1)
        apart = points[pairs[:, 0]] - points[pairs[:, 1]]
        found.append(pairs[np.sqrt((apart * apart).sum(axis=1)) <= reach])
    return np.concatenate(found) if found else np.zeros((0, 2), dtype=np.int64)


def _tolerance(size: float) -> float:
    """How near [m] two points of a surface that is `size` [m] across count as one."""
    return min(max(_SAME, _SAME_OF_SIZE * size), _LEAST_OF_SIZE * size)
