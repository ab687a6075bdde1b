"""Triangles in a tree of boxes: exact distances from them, and the largest value of a function on them."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface

Numbers = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Corners = npt.NDArray[np.float64]
"""(m, 3, 3): the corners of triangles [m]."""

BRANCHES = 4
_LONGEST = 1 / 16  # of the diagonal: the boxes around longer edges are mostly empty
_MOST_CUT = 1 << 17
_PAIRS = 1 << 17  # pairs of a point and a box looked at in one go
_FINER = 5
_MOST_BOXES = 1000
_MOST_PARTS = 400
_CODED = 10  # bits of each coordinate in the order along the curve


@dataclass(frozen=True, slots=True, eq=False)
class Value:
    """A function at points (n,): its value, or one that it is not above; whether it counts, being exact there
    and of use; and how far around it is of no use."""

    value: Numbers
    counts: npt.NDArray[np.bool_]
    idle: Numbers


@dataclass(frozen=True, slots=True, eq=False)
class BoxTree:
    """Triangles in the order of a space-filling curve, and boxes around each 1, 4, 16 ... that follow.

    `corners` (m, 3, 3) [m]: long triangles are cut in pieces. `faces` (m,): of which triangle of the
    surface each is a piece. `boxes`: of each level the lowest and highest corners.
    """

    corners: Corners
    faces: Indices
    boxes: tuple[tuple[Points, Points], ...]
    diagonal: float

    @staticmethod
    def of(surface: Surface, cut: bool = True) -> "BoxTree":
        """`cut`: whether long triangles are cut in pieces, which takes longer than a few searches do."""
        corners, faces = surface.corners, np.arange(len(surface.triangles))
        # NumPy is much slower along an axis of columns than with a column at a time.
        columns = np.moveaxis(corners, 2, 0)
        low = np.array([column.min() for column in columns])
        high = np.array([column.max() for column in columns])
        diagonal = float(np.sqrt(((high - low) ** 2).sum()))
        if cut:
            corners, faces = _cut(corners, faces, _LONGEST * diagonal)
        a, b, c = np.moveaxis(corners, 1, 0)
        # The place in the lower bits: equal codes keep their order, and a sort is faster than one of indices.
        code = _code((a + b + c) / 3, low, high) << 32 | np.arange(len(corners))
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
        """The boxes of `level` within boxes of the level above: for each which of `nodes`, and its index."""
        below = nodes[:, None] * BRANCHES + np.arange(BRANCHES)
        which, column = np.nonzero(below < len(self.boxes[level][0]))
        return which, below[which, column]

    def nearer(self, points: Points, known: Numbers) -> Numbers:
        """(n,): the distance [m] of each of the points (n, 3) from the nearest triangle, which is at most the
        `known` one."""
        best = known.copy()
        self.improve(points, best, known * known, np.arange(len(points)))
        return best

    def improve(self, points: Points, best: Numbers, least: Numbers, whose: Indices) -> None:
        """Lowers, in place, the `best` distances [m] of the points `whose` by those from triangles in boxes
        whose squared distance is below `least`."""
        self._improve(points, best, least, whose, np.zeros(len(whose), dtype=np.int64), len(self.boxes))

    def _improve(
        self, points: Points, best: Numbers, least: Numbers, whose: Indices, nodes: Indices, level: int
    ) -> None:
        """Goes down from boxes of `level` (or the root above all) for the points `whose`."""
        while level:
            if len(whose) * BRANCHES > _PAIRS and len(whose) > 1:
                half = len(whose) // 2
                self._improve(points, best, least, whose[:half], nodes[:half], level)
                whose, nodes = whose[half:], nodes[half:]
                continue
            level -= 1
            which, nodes = self.children(level, nodes)
            whose = whose[which]
            lows, highs = self.boxes[level]
            here = points.take(whose, axis=0)
            beyond = np.maximum(lows.take(nodes, axis=0) - here, here - highs.take(nodes, axis=0))
            np.maximum(beyond, 0.0, out=beyond)
            near = np.flatnonzero(_dot(beyond, beyond) < least[whose])
            whose, nodes = whose[near], nodes[near]
        points, corners = points.take(whose, axis=0), self.corners.take(nodes, axis=0)
        np.minimum.at(best, whose, triangle_distances(points, corners))


@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """Distances from the triangles of a tree, right to a fifty-thousandth of its diagonal."""

    tree: BoxTree
    seeds: "object"
    within: float

    @staticmethod
    def of(tree: BoxTree) -> "Nearest":
        # Late: a part from the cache needs no library that makes colliders or decimates.
        from scipy.spatial import cKDTree

        return Nearest(tree, cKDTree(tree.corners.mean(axis=1)), 2e-5 * tree.diagonal)

    def __call__(
        self, points: Points, from_on: Numbers | float = 0.0
    ) -> tuple[Numbers, npt.NDArray[np.bool_]]:
        """The distance [m] of each of the points (n, 3) from the nearest triangle, and whether it is exact.

        Where it is below `from_on` (n,) it is only known to be no more than the first value.
        """
        if not len(points):
            return np.zeros(0), np.zeros(0, dtype=bool)
        seeds = self.seeds.query(points, eps=0.3)[1]  # type: ignore[attr-defined]
        best = triangle_distances(points, self.tree.corners[seeds])
        least = np.maximum(best - self.within, 0.0) ** 2
        exact = best >= from_on
        for some in split(np.flatnonzero(exact), 4096):
            self.tree.improve(points, best, least, some)
        return best, exact


def triangle_distances(points: Points, corners: Corners) -> Numbers:
    """(n,): the distance [m] of each of the points (n, 3) from its own triangle (n, 3, 3)."""
    a = corners[:, 0]
    first, second, here = corners[:, 1] - a, corners[:, 2] - a, points - a
    aa, ab, bb = _dot(first, first), _dot(first, second), _dot(second, second)
    pa, pb = _dot(here, first), _dot(here, second)
    area = aa * bb - ab * ab
    v, w = bb * pa - ab * pb, aa * pb - ab * pa
    over = (v >= 0) & (w >= 0) & (v + w <= area) & (area > 0)
    safe = np.where(over, area, 1.0)[:, None]
    off = here - first * v[:, None] / safe - second * w[:, None] / safe
    result = _dot(off, off)
    rest = np.flatnonzero(~over)
    first, second, here = first[rest], second[rest], here[rest]
    third, there = second - first, here - first
    squares = [
        _segment(here, first, pa[rest], aa[rest]),
        _segment(here, second, pb[rest], bb[rest]),
        _segment(there, third, _dot(there, third), _dot(third, third)),
    ]
    result[rest] = np.minimum.reduce(squares)
    return np.asarray(np.sqrt(result), dtype=np.float64)


Function = Callable[[Points, Indices, Numbers], Value]
"""Takes points (n, 3), the triangles of the tree that they are on (n,), and the values (n,) from which on
it has to be exact."""


def largest(tree: BoxTree, function: Function, known: float, within: float) -> float:
    """The largest value, at least `known`, of a function on a tree's triangles, right to `within`.

    The function may not change by more than 1 a metre (Lipschitz): around a point it is nowhere above its
    value there plus the distance. What could still hold more is cut finer, 1,000 boxes or 400 parts of
    triangles a step, the most promising first; so on wide plains of one height not every place is looked at.
    """
    best = known
    nodes: Indices = np.zeros(1, dtype=np.int64)
    for level in range(len(tree.boxes) - 1, -1, -1):
        _, nodes = tree.children(level, nodes)
        span = BRANCHES**level
        middles = np.minimum(nodes * span + span // 2, len(tree.corners) - 1)
        points = tree.corners[middles].mean(axis=1)
        lows, highs = tree.boxes[level]
        far = np.maximum(np.abs(points - lows[nodes]), np.abs(points - highs[nodes]))
        reach = np.sqrt(_dot(far, far))
        found = function(points, middles, best + within - reach)
        best, kept = _promising(found, reach, best, within, _MOST_BOXES)
        nodes = nodes[kept]
    corners, owners = tree.corners[nodes], nodes
    for _ in range(_FINER):
        if not len(owners):
            break
        corners, owners = _quartered(corners), np.repeat(owners, 4)
        points = corners.mean(axis=1)
        reach = np.sqrt(((corners - points[:, None]) ** 2).sum(axis=2)).max(axis=1)
        found = function(points, owners, best + within - reach)
        best, kept = _promising(found, reach, best, within, _MOST_PARTS)
        corners, owners = corners[kept], owners[kept]
    return best


def _promising(found: Value, reach: Numbers, best: float, within: float, most: int) -> tuple[float, Indices]:
    """The best value now, and what may hold more within its reach: the `most` promising."""
    best = max(best, float(found.value[found.counts].max(initial=0.0)))
    bound = np.where(found.idle < reach, found.value + reach, 0.0)
    kept = np.flatnonzero(bound > best + within)
    if len(kept) > most:
        kept = kept[np.argsort(-bound[kept], kind="stable")[:most]]
        kept.sort()
    return best, kept


def _quartered(corners: Corners) -> Corners:
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3, 3)


def _cut(corners: Corners, faces: Indices, longest: float) -> tuple[Corners, Indices]:
    """The triangles, halved across the longest edge until none is longer than `longest`."""
    done: list[tuple[Corners, Indices]] = []
    count = len(faces)
    while longest > 0 and len(faces):
        edges = np.roll(corners, -1, axis=1) - corners
        squares = (edges * edges).sum(axis=2)
        widest = squares.argmax(axis=1)
        long = squares.max(axis=1) > longest * longest
        if not long.any() or count > _MOST_CUT:
            break
        done.append((corners[~long], faces[~long]))
        turn = (widest[long, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(np.take_along_axis(corners[long], turn[:, :, None], axis=1), 1, 0)
        middle = (a + b) / 2
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        faces = np.tile(faces[long], 2)
        count += len(faces) // 2
    done.append((corners, faces))
    every, whose = (np.concatenate(list(column)) for column in zip(*done, strict=True))
    return every, whose


def _code(points: Points, low: Numbers, high: Numbers) -> Indices:
    """The place of each point along a Morton curve through the box."""
    size = np.where(high > low, high - low, 1.0)
    cells = np.minimum(((points - low) / size * 2**_CODED).astype(np.int64), 2**_CODED - 1)
    # Two free bits after each bit of a coordinate, for those of the other two.
    for shift, mask in ((16, 0x30000FF), (8, 0x300F00F), (4, 0x30C30C3), (2, 0x9249249)):
        cells = (cells | cells << shift) & mask
    return np.asarray(cells[:, 0] | cells[:, 1] << 1 | cells[:, 2] << 2, dtype=np.int64)


def _segment(here: Points, edge: Points, along: Numbers, square: Numbers) -> Numbers:
    """The squared distance of points from the edges that start at their origin."""
    place = np.clip(np.divide(along, square, out=np.zeros_like(along), where=square > 0), 0.0, 1.0)
    off = here - edge * place[:, None]
    return _dot(off, off)


def _dot(a: Points, b: Points) -> Numbers:
    return np.asarray(np.einsum("ij,ij->i", a, b), dtype=np.float64)


def split(indices: Indices, size: int) -> Iterator[Indices]:
    """Indices in groups of at most `size`."""
    for begin in range(0, len(indices), size):
        yield indices[begin : begin + size]
