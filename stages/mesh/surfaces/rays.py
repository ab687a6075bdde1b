"""Where straight lines cross a surface."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface, Triangles
from linkwright.stages.mesh.surfaces.pieces import along

Indices = npt.NDArray[np.int64]

_PAIRS = 1 << 18  # pairs of a point and a triangle looked at in one go
_LEVELS = 24
_SIDE = 1 << 25  # cells of a level, at most, along each axis
DIRECTIONS = 6
_MOST_STRIPS = 16
_FINEST = 128  # strips over the whole size, at most
_TURN = (3 - math.sqrt(5)) * math.pi  # between neighbours of a Fibonacci lattice


@dataclass(frozen=True, slots=True, eq=False)
class Crossings:
    """Which of the points see which triangles straight above or below: one entry for each crossing.

    `sign`: +1 where the line, upwards, leaves through the triangle's outside, −1 where it enters.
    """

    points: Indices
    triangles: Indices
    sign: npt.NDArray[np.int8]
    above: npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class LineGrid:
    """A surface made ready to be crossed by lines of one direction.

    Each triangle is cut across its longest edge into strips about as long as they are wide. The strips lie
    in squares of a hierarchy of grids across the direction, each in the grid whose squares are about as large
    as it is, so that it lies in four of them at most. `keys`, sorted, name a grid and a square, `members` the
    strip that lies there; of the strips `owners` are the triangles.
    """

    axes: Points
    vertices: Points
    triangles: Triangles
    low: npt.NDArray[np.float64]
    size: float
    levels: Indices
    keys: Indices
    members: Indices
    strips: "_Strips"

    @staticmethod
    def of(surface: Surface, number: int = 0) -> "LineGrid":
        """For direction `number`, 0 to 5, of a lattice on the half sphere that has no axis in it."""
        axes = _axes(number)
        vertices = along(axes, surface.vertices).T.copy()
        flat = vertices[:, :2]
        low = flat.min(axis=0) if len(flat) else np.zeros(2)
        size = float(np.ptp(flat, axis=0).max(initial=0.0)) if len(flat) else 0.0
        size = size * (1 + 1e-9) or 1.0
        strips = _Strips.of(flat[surface.triangles], size)
        width = (strips.high - strips.low).max(axis=1, initial=0.0)
        with np.errstate(divide="ignore"):
            level = np.floor(np.log2(size / np.maximum(width, size * 2.0**-_LEVELS))).astype(np.int64)
        level = np.maximum(level, 0)
        cells = np.exp2(level)[:, None] / size
        begin, end = ((edge - low) * cells for edge in (strips.low, strips.high))
        begin, end = np.floor(begin).astype(np.int64), np.floor(end).astype(np.int64)
        keys, members = [], []
        for offset in itertools.product((0, 1, 2), repeat=2):
            here = begin + offset
            within = np.flatnonzero((here <= end).all(axis=1))
            keys.append(_key(level[within], here[within]))
            members.append(within)
        every, whose = np.concatenate(keys), np.concatenate(members)
        order = np.argsort(every, kind="stable")
        used = np.unique(level)
        return LineGrid(
            axes, vertices, surface.triangles, low, size, used, every[order], whose[order], strips
        )

    def crossings(self, points: Points) -> Iterator[Crossings]:
        """The crossings of the lines through points (n, 3), in portions."""
        local = along(self.axes, points).T
        cells = (local[:, :2] - self.low) / self.size
        beside = ((cells < 0) | (cells >= 1)).any(axis=1)
        for level in self.levels:
            key = _key(level, np.floor(cells * 2.0**level).astype(np.int64))
            begin = np.searchsorted(self.keys, key, side="left")
            count = np.searchsorted(self.keys, key, side="right") - begin
            count[beside] = 0
            for chosen in _portions(count):
                whose = np.repeat(chosen, count[chosen])
                starts = np.repeat(begin[chosen] - np.cumsum(count[chosen]) + count[chosen], count[chosen])
                found = self._crossed(whose, local, self.members[starts + np.arange(len(whose))])
                if len(found.points):
                    yield found

    def _crossed(self, whose: Indices, points: Points, strips: Indices) -> Crossings:
        """The pairs of a point and a strip that cross.

        The side of an edge on which a point lies is worked out from the edge alone, in one sense, so that
        a line through it crosses exactly one of its two triangles.
        """
        near = self.strips.near(strips, points[whose, :2])
        whose, strips = whose[near], strips[near]
        which, here = self.strips.owners[strips], points[whose]
        corners = self.triangles[which]
        sides = [self._side(corners[:, k], corners[:, (k + 1) % 3], here) for k in range(3)]
        left = [side > 0 for side in sides]
        hit = np.flatnonzero((left[0] == left[1]) & (left[1] == left[2]))
        hit = hit[self.strips.own(strips[hit], here[hit, :2])]
        corners, sides = corners[hit], [side[hit] for side in sides]
        total = sides[0] + sides[1] + sides[2]
        weights = [np.divide(side, total, out=np.full(len(total), 1 / 3), where=total != 0) for side in sides]
        heights = [self.vertices[corners[:, (k + 2) % 3], 2] * weights[k] for k in range(3)]
        above = heights[0] + heights[1] + heights[2] > here[hit, 2]
        return Crossings(whose[hit], which[hit], np.where(left[0][hit], 1, -1).astype(np.int8), above)

    def _side(self, a: Indices, b: Indices, points: Points) -> npt.NDArray[np.float64]:
        """Twice the area of the triangle of edge and point, > 0 on the left; never 0."""
        first, second = self.vertices[np.minimum(a, b)], self.vertices[np.maximum(a, b)]
        ahead, aside = second[:, :2] - first[:, :2], points[:, :2] - first[:, :2]
        area = ahead[:, 0] * aside[:, 1] - ahead[:, 1] * aside[:, 0]
        area = np.where(area == 0, np.finfo(float).tiny, area)
        return np.where(a < b, area, -area)


@dataclass(frozen=True, slots=True, eq=False)
class _Strips:
    """Triangles in the plane, cut across their longest edges: for each strip its triangle (`owners`), which
    of its strips it is (`number` of `of_all`), and its bounds; for each triangle where the longest edge
    starts, and that edge over its squared length, so that a point's place along it is a product."""

    owners: Indices
    number: Indices
    of_all: Indices
    low: npt.NDArray[np.float64]
    high: npt.NDArray[np.float64]
    starts: npt.NDArray[np.float64]
    edges: npt.NDArray[np.float64]

    @staticmethod
    def of(corners: npt.NDArray[np.float64], size: float) -> "_Strips":
        """Of triangles (m, 3, 2) that are `size` across in all."""
        every = np.roll(corners, -1, axis=1) - corners
        squares = (every * every).sum(axis=2)
        longest = squares.argmax(axis=1)
        rows = np.arange(len(corners))
        starts, edge, square = corners[rows, longest], every[rows, longest], squares[rows, longest]
        apex = corners[rows, (longest + 2) % 3] - starts
        square = np.where(square > 0, square, 1.0)
        double = np.abs(edge[:, 0] * apex[:, 1] - edge[:, 1] * apex[:, 0])
        most = np.minimum(
            square / np.maximum(double, square / _MOST_STRIPS), np.sqrt(square) * _FINEST / size
        )
        of_all = np.maximum(most.astype(np.int64), 1)
        owners = np.repeat(rows, of_all)
        number = np.arange(len(owners)) - np.repeat(np.cumsum(of_all) - of_all, of_all)
        edges = edge / square[:, None]
        middle = np.clip((apex * edges).sum(axis=1), 0.0, 1.0)[owners, None]
        begin, end = number / of_all[owners], (number + 1) / of_all[owners]
        edge, apex = edge[owners], apex[owners]
        bounds = [edge * begin[:, None], edge * end[:, None]]
        for place in (begin[:, None], end[:, None], np.clip(middle, begin[:, None], end[:, None])):
            up = np.divide(place, middle, out=np.ones_like(place), where=middle > 0)
            down = np.divide(1 - place, 1 - middle, out=np.ones_like(place), where=middle < 1)
            share = np.minimum(np.minimum(up, down), 1.0)
            bounds.append(edge * place + (apex - edge * middle) * share)
        slack = 1e-9 * size
        low = np.minimum.reduce(bounds) + starts[owners] - slack
        high = np.maximum.reduce(bounds) + starts[owners] + slack
        return _Strips(owners, number, of_all, low, high, starts, edges)

    def near(self, strips: Indices, points: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Whether each point (n, 2) is within the bounds of its strip (n,)."""
        low, high = self.low[strips], self.high[strips]
        x, y = points.T
        return np.asarray((low[:, 0] <= x) & (x <= high[:, 0]) & (low[:, 1] <= y) & (y <= high[:, 1]))

    def own(self, strips: Indices, points: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Whether each strip (n,) is the one of its triangle that has the point (n, 2)."""
        owners = self.owners[strips]
        place = ((points - self.starts[owners]) * self.edges[owners]).sum(axis=1)
        count = self.of_all[owners]
        return np.asarray(np.clip(np.floor(place * count), 0, count - 1) == self.number[strips])


def _axes(number: int) -> Points:
    """(3, 3): rows are a frame whose last axis is the direction."""
    height = (number + 0.37) / DIRECTIONS
    turn = 0.61 + number * _TURN
    width = math.sqrt(1 - height * height)
    direction = [width * math.cos(turn), width * math.sin(turn), height]
    aside = [-math.sin(turn + 0.83), math.cos(turn + 0.83), 0.23]
    first = np.cross(direction, aside)
    first /= math.sqrt(float((first * first).sum()))
    return np.array([first, np.cross(direction, first), direction])


def _key(level: npt.NDArray[np.int64] | np.int64, cell: Indices) -> Indices:
    """A grid and a square of it as one number."""
    return np.asarray((level * _SIDE + cell[:, 0]) * _SIDE + cell[:, 1], dtype=np.int64)


def _portions(count: Indices) -> Iterator[Indices]:
    """The points with anything to look at, in groups with so many pairs in all as fit in memory."""
    some = np.flatnonzero(count)
    group = np.cumsum(count[some]) // _PAIRS
    for portion in np.split(some, np.flatnonzero(np.diff(group)) + 1):
        if len(portion):
            yield portion
