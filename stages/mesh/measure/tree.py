"""Sorts triangles into a tree of boxes, for exact distances and for the largest value of a function on
them."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from linkwright.stages.formats.meshes.surface import Points, Surface

Numbers = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Corners = npt.NDArray[np.float64]
"""Corners of triangles (m, 3, 3) [m]."""

BRANCHES = 4  # boxes in a box of the next level
_MAX_EDGE_SHARE = 1 / 16  # of the diagonal: the boxes around longer edges are mostly empty
_MAX_CUT_TRIANGLES = 1 << 17
_MAX_PAIRS = 1 << 17  # pairs of a point and a box that are compared at once
_MAX_QUARTERINGS = 5
_MAX_BOXES = 1000
_MAX_PARTS = 400
_CODE_BITS = 10  # bits of each coordinate in the order along the curve


@dataclass(frozen=True, slots=True, eq=False)
class Value:
    """The values of a function at points."""

    value: Numbers
    """Value at each point (n,), or an upper bound of it."""
    counts: npt.NDArray[np.bool_]
    """Whether each value is exact and counts for the maximum (n,)."""
    idle: Numbers
    """Radius around each point in which no value counts (n,) [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxTree:
    """Triangles in the order of a space-filling curve, with boxes around groups of 1, 4, 16 ... triangles."""

    corners: Corners
    """Corners of the triangles (m, 3, 3) [m]; long triangles are cut into pieces."""
    faces: Indices
    """Index of the triangle of the surface of which each is a piece (m,)."""
    boxes: tuple[tuple[Points, Points], ...]
    """Lowest and highest corners of the boxes of each level, which begins with single triangles."""
    diagonal: float
    """Diagonal of all triangles' bounding box [m]."""

    @staticmethod
    def of(surface: Surface, cut: bool = True) -> "BoxTree":
        """Builds the tree of a surface. `cut`: whether long triangles are cut into pieces, which takes longer
        than a few searches."""
        corners, faces = surface.corners, np.arange(len(surface.triangles))
        # NumPy is much slower along an axis of columns than with a column at a time.
        columns = np.moveaxis(corners, 2, 0)
        low = np.array([column.min() for column in columns])
        high = np.array([column.max() for column in columns])
        diagonal = float(np.sqrt(((high - low) ** 2).sum()))
        if cut:
            corners, faces = _cut(corners, faces, _MAX_EDGE_SHARE * diagonal)
        a, b, c = np.moveaxis(corners, 1, 0)
        # The index is in the lower bits: equal codes keep their order, and sorting is faster than an argsort.
        code = _morton_codes((a + b + c) / 3, low, high) << 32 | np.arange(len(corners))
        order = np.sort(code) & 0xFFFFFFFF
        corners, faces = corners.take(order, axis=0), faces[order]
        a, b, c = np.moveaxis(corners, 1, 0)
        boxes = [(np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c))]
        while len(boxes[-1][0]) > BRANCHES:
            starts = np.arange(0, len(boxes[-1][0]), BRANCHES)
            lows, highs = boxes[-1]
            boxes.append((np.minimum.reduceat(lows, starts), np.maximum.reduceat(highs, starts)))
        return BoxTree(corners, faces, tuple(boxes), diagonal)

    def children(self, level: int, nodes: Indices) -> tuple[Indices, Indices]:
        """Returns the boxes of `level` within the boxes `nodes` of the level above: for each the position of
        its parent in `nodes`, and its index."""
        below = nodes[:, None] * BRANCHES + np.arange(BRANCHES)
        parents, column = np.nonzero(below < len(self.boxes[level][0]))
        return parents, below[parents, column]

    def nearer(self, points: Points, bounds: Numbers) -> Numbers:
        """Returns the distance [m] (n,) of each of the points (n, 3) from the nearest triangle. `bounds`
        (n,): upper bounds of these distances."""
        best = bounds.copy()
        self.improve(points, best, bounds * bounds, np.arange(len(points)))
        return best

    def improve(self, points: Points, best: Numbers, least: Numbers, point_indices: Indices) -> None:
        """Lowers, in place, the `best` distances [m] of the points with these indices, if a triangle is
        nearer. Only boxes are searched whose squared distance is below `least`."""
        self._improve(
            points, best, least, point_indices, np.zeros(len(point_indices), dtype=np.int64), len(self.boxes)
        )

    def _improve(
        self,
        points: Points,
        best: Numbers,
        least: Numbers,
        point_indices: Indices,
        nodes: Indices,
        level: int,
    ) -> None:
        """Searches the boxes below `nodes` of `level` (or below the root) for the points with these
        indices."""
        while level:
            if len(point_indices) * BRANCHES > _MAX_PAIRS and len(point_indices) > 1:
                half = len(point_indices) // 2
                self._improve(points, best, least, point_indices[:half], nodes[:half], level)
                point_indices, nodes = point_indices[half:], nodes[half:]
                continue
            level -= 1
            parent_rows, nodes = self.children(level, nodes)
            point_indices = point_indices[parent_rows]
            lows, highs = self.boxes[level]
            points_of_pairs = points.take(point_indices, axis=0)
            distances = np.maximum(
                lows.take(nodes, axis=0) - points_of_pairs, points_of_pairs - highs.take(nodes, axis=0)
            )
            np.maximum(distances, 0.0, out=distances)
            nearby = np.flatnonzero(_dot(distances, distances) < least[point_indices])
            point_indices, nodes = point_indices[nearby], nodes[nearby]
        points, corners = points.take(point_indices, axis=0), self.corners.take(nodes, axis=0)
        np.minimum.at(best, point_indices, triangle_distances(points, corners))


@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """Distances from the triangles of a tree, exact to a fifty-thousandth of its diagonal."""

    tree: BoxTree
    seeds: "object"
    """KD-tree of the triangles' centroids."""
    within: float
    """Largest error [m]."""

    @staticmethod
    def of(tree: BoxTree) -> "Nearest":
        """Prepares the distances from a tree."""
        return Nearest(tree, scipy.spatial.cKDTree(tree.corners.mean(axis=1)), 2e-5 * tree.diagonal)

    def __call__(
        self, points: Points, exact_from: Numbers | float = 0.0
    ) -> tuple[Numbers, npt.NDArray[np.bool_]]:
        """Returns the distance [m] (n,) of each of the points (n, 3) from the nearest triangle, and whether
        it is exact.

        Distances below `exact_from` (n,) may be upper bounds.
        """
        if not len(points):
            return np.zeros(0), np.zeros(0, dtype=bool)
        seeds = self.seeds.query(points, eps=0.3)[1]  # type: ignore[attr-defined]
        best = triangle_distances(points, self.tree.corners[seeds])
        least = np.maximum(best - self.within, 0.0) ** 2
        exact = best >= exact_from
        for batch in split(np.flatnonzero(exact), 4096):
            self.tree.improve(points, best, least, batch)
        return best, exact


def triangle_distances(points: Points, corners: Corners) -> Numbers:
    """Returns the distance [m] (n,) of each of the points (n, 3) from its own triangle (n, 3, 3)."""
    a = corners[:, 0]
    from_a, edge_ac, from_first = corners[:, 1] - a, corners[:, 2] - a, points - a
    aa, ab, bb = _dot(from_a, from_a), _dot(from_a, edge_ac), _dot(edge_ac, edge_ac)
    pa, pb = _dot(from_first, from_a), _dot(from_first, edge_ac)
    area = aa * bb - ab * ab
    v, w = bb * pa - ab * pb, aa * pb - ab * pa
    above_face = (v >= 0) & (w >= 0) & (v + w <= area) & (area > 0)
    safe = np.where(above_face, area, 1.0)[:, None]
    offsets = from_first - from_a * v[:, None] / safe - edge_ac * w[:, None] / safe
    result = _dot(offsets, offsets)
    not_above = np.flatnonzero(~above_face)
    from_a, edge_ac, from_first = from_a[not_above], edge_ac[not_above], from_first[not_above]
    third, from_second = edge_ac - from_a, from_first - from_a
    squares = [
        _squared_segment_distances(from_first, from_a, pa[not_above], aa[not_above]),
        _squared_segment_distances(from_first, edge_ac, pb[not_above], bb[not_above]),
        _squared_segment_distances(from_second, third, _dot(from_second, third), _dot(third, third)),
    ]
    result[not_above] = np.minimum.reduce(squares)
    return np.asarray(np.sqrt(result), dtype=np.float64)


Function = Callable[[Points, Indices, Numbers], Value]
"""Function of points (n, 3), of the indices of the triangles that they lie on (n,), and of the values (n,)
from which on it must be exact."""


def largest(tree: BoxTree, function: Function, least: float, within: float) -> float:
    """Returns the largest value of a function on a tree's triangles, but at least `least`, exact to `within`.

    The function must be Lipschitz with the constant 1: near a point, it exceeds the value at the point by at
    most the distance. Boxes that may contain a larger value are divided, at most 1,000 boxes or 400 parts of
    triangles in each step, the most promising first. On a wide plateau not every place is therefore tried."""
    best = least
    nodes: Indices = np.zeros(1, dtype=np.int64)
    for level in range(len(tree.boxes) - 1, -1, -1):
        _, nodes = tree.children(level, nodes)
        span = BRANCHES**level
        middles = np.minimum(nodes * span + span // 2, len(tree.corners) - 1)
        points = tree.corners[middles].mean(axis=1)
        lows, highs = tree.boxes[level]
        half_extents = np.maximum(np.abs(points - lows[nodes]), np.abs(points - highs[nodes]))
        reach = np.sqrt(_dot(half_extents, half_extents))
        values = function(points, middles, best + within - reach)
        best, promising = _promising(values, reach, best, within, _MAX_BOXES)
        nodes = nodes[promising]
    corners, owners = tree.corners[nodes], nodes
    for _ in range(_MAX_QUARTERINGS):
        if not len(owners):
            break
        corners, owners = _quartered(corners), np.repeat(owners, 4)
        points = corners.mean(axis=1)
        reach = np.sqrt(((corners - points[:, None]) ** 2).sum(axis=2)).max(axis=1)
        values = function(points, owners, best + within - reach)
        best, promising = _promising(values, reach, best, within, _MAX_PARTS)
        corners, owners = corners[promising], owners[promising]
    return best


def _promising(
    values: Value, reach: Numbers, best: float, within: float, max_count: int
) -> tuple[float, Indices]:
    """Returns the best value so far, and the indices of at most `max_count` points within whose reach the
    function may be larger."""
    best = max(best, float(values.value[values.counts].max(initial=0.0)))
    bound = np.where(values.idle < reach, values.value + reach, 0.0)
    candidates = np.flatnonzero(bound > best + within)
    if len(candidates) > max_count:
        candidates = candidates[np.argsort(-bound[candidates], kind="stable")[:max_count]]
        candidates.sort()
    return best, candidates


def _quartered(corners: Corners) -> Corners:
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3, 3)


def _cut(corners: Corners, faces: Indices, longest: float) -> tuple[Corners, Indices]:
    """Halves triangles across their longest edges until no edge is longer than `longest`."""
    finished: list[tuple[Corners, Indices]] = []
    count = len(faces)
    while longest > 0 and len(faces):
        edges = np.roll(corners, -1, axis=1) - corners
        squares = (edges * edges).sum(axis=2)
        widest = squares.argmax(axis=1)
        is_long = squares.max(axis=1) > longest * longest
        if not is_long.any() or count > _MAX_CUT_TRIANGLES:
            break
        finished.append((corners[~is_long], faces[~is_long]))
        turn = (widest[is_long, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(np.take_along_axis(corners[is_long], turn[:, :, None], axis=1), 1, 0)
        middle = (a + b) / 2
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        faces = np.tile(faces[is_long], 2)
        count += len(faces) // 2
    finished.append((corners, faces))
    all_corners, all_faces = (np.concatenate(list(column)) for column in zip(*finished, strict=True))
    return all_corners, all_faces


def _morton_codes(points: Points, low: Numbers, high: Numbers) -> Indices:
    """Returns the position of each point along a Morton curve through the box."""
    size = np.where(high > low, high - low, 1.0)
    cells = np.minimum(((points - low) / size * 2**_CODE_BITS).astype(np.int64), 2**_CODE_BITS - 1)
    # Spreads the bits of a coordinate, with two free bits between them for the other two coordinates.
    for shift, mask in ((16, 0x30000FF), (8, 0x300F00F), (4, 0x30C30C3), (2, 0x9249249)):
        cells = (cells | cells << shift) & mask
    return np.asarray(cells[:, 0] | cells[:, 1] << 1 | cells[:, 2] << 2, dtype=np.int64)


def _squared_segment_distances(
    points: Points, edge: Points, along: Numbers, squared_length: Numbers
) -> Numbers:
    """Returns the squared distance (n,) of points (n, 3) from edges that start at the origin. `along`: dot
    product of each point and its edge; `squared_length`: of the edge."""
    share = np.clip(
        np.divide(along, squared_length, out=np.zeros_like(along), where=squared_length > 0), 0.0, 1.0
    )
    offsets = points - edge * share[:, None]
    return _dot(offsets, offsets)


def _dot(a: Points, b: Points) -> Numbers:
    return np.asarray(np.einsum("ij,ij->i", a, b), dtype=np.float64)


def split(indices: Indices, size: int) -> Iterator[Indices]:
    """Yields indices in groups of at most `size`."""
    for begin in range(0, len(indices), size):
        yield indices[begin : begin + size]
