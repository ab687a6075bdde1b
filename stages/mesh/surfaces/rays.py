"""Finds where straight lines cross a surface."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface, Triangles
from linkwright.stages.mesh.surfaces.pieces import along

Indices = npt.NDArray[np.int64]

_MAX_PAIRS = 1 << 18  # pairs of a point and a strip that are tested at once
_MAX_LEVEL = 24
_MAX_CELLS = 1 << 25  # of a level along each axis
DIRECTION_COUNT = 6  # of lines through a surface with holes
_MAX_STRIPS = 16  # of a triangle
_MAX_STRIPS_OVER_SIZE = 128  # of an edge as long as the whole surface
_GOLDEN_ANGLE = (3 - math.sqrt(5)) * math.pi  # between neighbours of a Fibonacci lattice [rad]


@dataclass(frozen=True, slots=True, eq=False)
class Crossings:
    """Crossings of vertical lines through points with triangles."""

    points: Indices
    """Index of the point of each crossing."""
    triangles: Indices
    """Index of the crossed triangle."""
    sign: npt.NDArray[np.int8]
    """+1 if the line, upwards, leaves through the triangle's outside, −1 if it enters."""
    above: npt.NDArray[np.bool_]
    """Whether each crossing is above its point."""


@dataclass(frozen=True, slots=True, eq=False)
class LineGrid:
    """A surface that is prepared for crossings with lines of one direction.

    Each triangle is cut across its longest edge into strips that are about as long as they are wide. The
    strips lie in squares of a hierarchy of grids across the direction: each strip in the grid whose squares
    are about as large as the strip, so that few squares contain it.
    """

    axes: Points
    """Frame of the grids (3, 3), as rows; the last axis is the direction."""
    vertices: Points
    """Vertices (n, 3) in that frame."""
    triangles: Triangles
    low: npt.NDArray[np.float64]
    """Lowest corner (2,) of the grids."""
    size: float
    """Side length of the grids [m]."""
    levels: Indices
    """Levels of the hierarchy that have strips."""
    keys: Indices
    """Grid and square of each entry, as a number; sorted."""
    members: Indices
    """Index of the strip of each entry."""
    strips: "_Strips"

    @staticmethod
    def of(surface: Surface, number: int = 0) -> "LineGrid":
        """Prepares a surface for direction `number`, 0 to 5, of a lattice on the half sphere that avoids the
        coordinate axes."""
        axes = _axes(number)
        vertices = along(axes, surface.vertices).T.copy()
        projected = vertices[:, :2]
        low = projected.min(axis=0) if len(projected) else np.zeros(2)
        size = float(np.ptp(projected, axis=0).max(initial=0.0)) if len(projected) else 0.0
        size = size * (1 + 1e-9) or 1.0
        strips = _Strips.of(projected[surface.triangles], size)
        width = (strips.high - strips.low).max(axis=1, initial=0.0)
        with np.errstate(divide="ignore"):
            level = np.floor(np.log2(size / np.maximum(width, size * 2.0**-_MAX_LEVEL))).astype(np.int64)
        level = np.maximum(level, 0)
        cells = np.exp2(level)[:, None] / size
        begin, end = ((edge - low) * cells for edge in (strips.low, strips.high))
        begin, end = np.floor(begin).astype(np.int64), np.floor(end).astype(np.int64)
        keys, members = [], []
        for offset in itertools.product((0, 1, 2), repeat=2):
            cells_at_offset = begin + offset
            within = np.flatnonzero((cells_at_offset <= end).all(axis=1))
            keys.append(_key(level[within], cells_at_offset[within]))
            members.append(within)
        all_keys, all_members = np.concatenate(keys), np.concatenate(members)
        order = np.argsort(all_keys, kind="stable")
        used_levels = np.unique(level)
        return LineGrid(
            axes,
            vertices,
            surface.triangles,
            low,
            size,
            used_levels,
            all_keys[order],
            all_members[order],
            strips,
        )

    def crossings(self, points: Points) -> Iterator[Crossings]:
        """Yields the crossings of the lines through points (n, 3), in portions."""
        local = along(self.axes, points).T
        cells = (local[:, :2] - self.low) / self.size
        is_outside = ((cells < 0) | (cells >= 1)).any(axis=1)
        for level in self.levels:
            key = _key(level, np.floor(cells * 2.0**level).astype(np.int64))
            begin = np.searchsorted(self.keys, key, side="left")
            count = np.searchsorted(self.keys, key, side="right") - begin
            count[is_outside] = 0
            for group in _portions(count):
                point_indices = np.repeat(group, count[group])
                starts = np.repeat(begin[group] - np.cumsum(count[group]) + count[group], count[group])
                crossed = self._crossed(
                    point_indices, local, self.members[starts + np.arange(len(point_indices))]
                )
                if len(crossed.points):
                    yield crossed

    def _crossed(self, point_indices: Indices, points: Points, strips: Indices) -> Crossings:
        """Returns the crossings among pairs of a point and a strip.

        The side of an edge on which a point lies is computed from the edge in a fixed sense, the same for
        both of its triangles, so that a line near the edge crosses exactly one of them.
        """
        in_bounds = self.strips.near(strips, points[point_indices, :2])
        point_indices, strips = point_indices[in_bounds], strips[in_bounds]
        triangle_indices, points_of_pairs = self.strips.owners[strips], points[point_indices]
        corners = self.triangles[triangle_indices]
        sides = [self._side(corners[:, k], corners[:, (k + 1) % 3], points_of_pairs) for k in range(3)]
        is_left = [side > 0 for side in sides]
        hit = np.flatnonzero((is_left[0] == is_left[1]) & (is_left[1] == is_left[2]))
        hit = hit[self.strips.contains(strips[hit], points_of_pairs[hit, :2])]
        corners, sides = corners[hit], [side[hit] for side in sides]
        total = sides[0] + sides[1] + sides[2]
        weights = [np.divide(side, total, out=np.full(len(total), 1 / 3), where=total != 0) for side in sides]
        heights = [self.vertices[corners[:, (k + 2) % 3], 2] * weights[k] for k in range(3)]
        is_above = heights[0] + heights[1] + heights[2] > points_of_pairs[hit, 2]
        return Crossings(
            point_indices[hit],
            triangle_indices[hit],
            np.where(is_left[0][hit], 1, -1).astype(np.int8),
            is_above,
        )

    def _side(self, a: Indices, b: Indices, points: Points) -> npt.NDArray[np.float64]:
        """Returns twice the area of the triangle of an edge and a point, > 0 if the point is left; never
        0."""
        first, second = self.vertices[np.minimum(a, b)], self.vertices[np.maximum(a, b)]
        ahead, aside = second[:, :2] - first[:, :2], points[:, :2] - first[:, :2]
        area = ahead[:, 0] * aside[:, 1] - ahead[:, 1] * aside[:, 0]
        area = np.where(area == 0, np.finfo(float).tiny, area)
        return np.where(a < b, area, -area)


@dataclass(frozen=True, slots=True, eq=False)
class _Strips:
    """Strips of triangles in the plane, cut across the longest edge of each triangle."""

    owners: Indices
    """Index of each strip's triangle."""
    number: Indices
    """Index of each strip among the strips of its triangle."""
    counts: Indices
    """Number of strips of each triangle."""
    low: npt.NDArray[np.float64]
    high: npt.NDArray[np.float64]
    """Bounds of each strip (k, 2)."""
    starts: npt.NDArray[np.float64]
    """Start of each triangle's longest edge (m, 2)."""
    edges: npt.NDArray[np.float64]
    """Longest edge of each triangle over its squared length (m, 2): the share of the edge at which a point
    lies is the dot product with this vector."""

    @staticmethod
    def of(corners: npt.NDArray[np.float64], size: float) -> "_Strips":
        """Cuts triangles (m, 3, 2) into strips. `size`: extent of all triangles together."""
        all_edges = np.roll(corners, -1, axis=1) - corners
        squares = (all_edges * all_edges).sum(axis=2)
        longest = squares.argmax(axis=1)
        rows = np.arange(len(corners))
        starts, edge, square = corners[rows, longest], all_edges[rows, longest], squares[rows, longest]
        apex = corners[rows, (longest + 2) % 3] - starts
        square = np.where(square > 0, square, 1.0)
        doubled_area = np.abs(edge[:, 0] * apex[:, 1] - edge[:, 1] * apex[:, 0])
        strip_counts = np.minimum(
            square / np.maximum(doubled_area, square / _MAX_STRIPS),
            np.sqrt(square) * _MAX_STRIPS_OVER_SIZE / size,
        )
        counts = np.maximum(strip_counts.astype(np.int64), 1)
        owners = np.repeat(rows, counts)
        number = np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
        edges = edge / square[:, None]
        middle = np.clip((apex * edges).sum(axis=1), 0.0, 1.0)[owners, None]
        begin, end = number / counts[owners], (number + 1) / counts[owners]
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
        return _Strips(owners, number, counts, low, high, starts, edges)

    def near(self, strips: Indices, points: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Tells whether each point (n, 2) is within the bounds of its strip (n,)."""
        low, high = self.low[strips], self.high[strips]
        x, y = points.T
        return np.asarray((low[:, 0] <= x) & (x <= high[:, 0]) & (low[:, 1] <= y) & (y <= high[:, 1]))

    def contains(self, strips: Indices, points: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Tells whether each point (n, 2) belongs to its strip (n,), and not to another of the triangle."""
        owners = self.owners[strips]
        share_of_edge = ((points - self.starts[owners]) * self.edges[owners]).sum(axis=1)
        count = self.counts[owners]
        return np.asarray(np.clip(np.floor(share_of_edge * count), 0, count - 1) == self.number[strips])


def _axes(number: int) -> Points:
    """Returns a frame (3, 3), as rows, whose last axis is the direction `number`."""
    height = (number + 0.37) / DIRECTION_COUNT
    turn = 0.61 + number * _GOLDEN_ANGLE
    width = math.sqrt(1 - height * height)
    direction = [width * math.cos(turn), width * math.sin(turn), height]
    aside = [-math.sin(turn + 0.83), math.cos(turn + 0.83), 0.23]
    first = np.cross(direction, aside)
    first /= math.sqrt(float((first * first).sum()))
    return np.array([first, np.cross(direction, first), direction])


def _key(level: npt.NDArray[np.int64] | np.int64, cell: Indices) -> Indices:
    """Returns a number for a grid and a square of it."""
    return np.asarray((level * _MAX_CELLS + cell[:, 0]) * _MAX_CELLS + cell[:, 1], dtype=np.int64)


def _portions(count: Indices) -> Iterator[Indices]:
    """Yields the points with any pairs, in groups whose pairs fit in memory."""
    with_pairs = np.flatnonzero(count)
    group = np.cumsum(count[with_pairs]) // _MAX_PAIRS
    for portion in np.split(with_pairs, np.flatnonzero(np.diff(group)) + 1):
        if len(portion):
            yield portion
