"""Triangles as pixels: each point of the picture shows what is nearest to the viewer."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

Corners = npt.NDArray[np.floating[Any]]
"""(m, 3, 3): for each corner of a triangle how far to the right and down it is in the picture, in pixels, and
how far towards the viewer."""
Pixels = npt.NDArray[np.uint8]
"""(height, width, 3): red, green and blue, the first row at the top."""
Numbers = npt.NDArray[np.floating[Any]]
Indices = npt.NDArray[np.integer[Any]]

_AT_ONCE = 1 << 21  # pixels
_LEVELS = 1 << 20
_TRIANGLE_BITS = 26
_EDGE_ON = 1e-3  # twice the area that is seen, in pixels


def work(corners: Corners) -> float:
    """How many pixels are looked at to draw them, at most."""
    return float(_boxes(corners).sum())


def drawn(corners: Corners, colours: Pixels, background: Pixels, side: int) -> Pixels:
    """The picture, `side` pixels high and wide: of each triangle (fewer than 2^26) its colour (m, 3) where
    the centre of a pixel is in it, and elsewhere the background (3,)."""
    every: Pixels = np.concatenate([colours, background[None]])
    return np.asarray(every[seen(corners, side, side)])


def seen(corners: Corners, width: int, height: int) -> Indices:
    """(height, width): which triangle (of fewer than 2^26) is nearest to the viewer at the centre of each
    pixel, -1 for none.

    Depth is cut into 2^20 levels; of triangles on one level the last one is seen.
    """
    nearest = np.full(height * width, -1, dtype=np.int64)
    depth = corners[:, :, 2]
    low = float(depth.min(initial=np.inf))
    span = float(depth.max(initial=-np.inf)) - low
    step = _LEVELS / span if span > 0 else 0.0
    for some in _batches(corners, _with_centres(corners)):
        triangle, row, column, near = _covered(corners[some], width, height)
        level = np.clip((near - low) * step, 0, _LEVELS).astype(np.int64)
        level <<= _TRIANGLE_BITS
        level |= some[triangle]
        row *= width
        row += column
        np.maximum.at(nearest, row, level)
    nothing = (1 << _TRIANGLE_BITS) - 1
    nearest &= nothing
    found = nearest.astype(np.int32)
    found[found == nothing] = -1
    return found.reshape(height, width)


def _boxes(corners: Corners) -> Numbers:
    """(m,): the pixels of the box around each triangle."""
    a, b, c = np.moveaxis(corners[:, :, :2], 1, 0)
    # By pairs: reducing an axis of three takes several times as long.
    size = np.maximum(np.maximum(a, b), c) - np.minimum(np.minimum(a, b), c) + 1.0
    return np.asarray(size[:, 0] * size[:, 1])


def _with_centres(corners: Corners) -> Indices:
    """The triangles in whose box is the centre of a pixel."""
    found = np.ones(len(corners), dtype=np.bool_)
    for axis in range(2):
        a, b, c = np.moveaxis(corners[:, :, axis] - 0.5, 1, 0)
        found &= np.floor(np.maximum(np.maximum(a, b), c)) >= np.minimum(np.minimum(a, b), c)
    return np.flatnonzero(found)


def _batches(corners: Corners, which: Indices) -> Iterator[Indices]:
    """Some of the triangles, so many at a time that their pixels have room."""
    batch = (np.cumsum(_boxes(corners[which])) // _AT_ONCE).astype(np.int64)
    yield from np.split(which, np.flatnonzero(np.diff(batch)) + 1)


def _covered(corners: Corners, width: int, height: int) -> tuple[Indices, Indices, Indices, Numbers]:
    """The pixels whose centres are in a triangle: which triangle, row, column, and how near the viewer it is
    there. Row by row: where a row enters and leaves a triangle."""
    top, middle, bottom = _downwards(corners)
    owner, row = _between(top[1], bottom[1], height)
    y = row + corners.dtype.type(0.5)
    long = _Edge(top, bottom).at(owner, y)
    short = np.where(
        y < middle[1][owner], _Edge(top, middle).at(owner, y), _Edge(middle, bottom).at(owner, y)
    )
    span, column = _between(np.minimum(long, short), np.maximum(long, short), width)
    owner, row = owner[span], row[span]
    return owner, row, column, _height(corners, owner, column, row)


Places = tuple[Numbers, Numbers]


def _downwards(corners: Corners) -> tuple[Places, Places, Places]:
    """The corners of each triangle, right and down, the highest first."""
    a, b, c = ((corners[:, corner, 0], corners[:, corner, 1]) for corner in range(3))
    a, b = _swapped(a, b)
    b, c = _swapped(b, c)
    a, b = _swapped(a, b)
    return a, b, c


def _swapped(one: Places, other: Places) -> tuple[Places, Places]:
    """Both, the higher first."""
    below = one[1] > other[1]
    first, second = (
        tuple(np.where(below, there, here) for here, there in zip(*pair, strict=True))
        for pair in ((one, other), (other, one))
    )
    return (first[0], first[1]), (second[0], second[1])


class _Edge:
    """The edges from the places `start` to `end`, downwards."""

    def __init__(self, start: Places, end: Places) -> None:
        down = end[1] - start[1]
        self._start = start
        self._slope = np.divide(end[0] - start[0], down, out=np.zeros_like(down), where=down > 0)
        self._down = down

    def at(self, which: Indices, y: Numbers) -> Numbers:
        """Where these edges cross the rows at `y`."""
        passed = np.clip(y - self._start[1][which], 0.0, self._down[which])
        return np.asarray(self._start[0][which] + passed * self._slope[which])


def _between(start: Numbers, end: Numbers, side: int) -> tuple[Indices, Indices]:
    """The pixels of the picture with a centre within each interval, and the interval of each."""
    first = np.clip(np.ceil(start - 0.5), 0, side).astype(np.int32)
    after = np.clip(np.floor(end - 0.5) + 1, 0, side).astype(np.int32)
    count = np.maximum(after - first, 0)
    owner = np.repeat(np.arange(len(count), dtype=np.int32), count)
    # Of each pixel its number, less that of the first of its interval.
    found = np.arange(len(owner), dtype=np.int32)
    found += (first - (np.cumsum(count) - count).astype(np.int32))[owner]
    return owner, found


def _height(corners: Corners, owner: Indices, column: Indices, row: Indices) -> Numbers:
    """How near the viewer the triangles `owner` are in the middle of a pixel; of one that is seen edge-on,
    its nearest point."""
    a, b, c = np.moveaxis(corners, 1, 0)
    (ax, ay, az), (bx, by, bz) = (b - a).T, (c - a).T
    up = ax * by - ay * bx
    upright = np.abs(up) > _EDGE_ON
    up = np.where(upright, up, 1.0)
    across = np.where(upright, az * by - ay * bz, 0.0) / up
    down = np.where(upright, ax * bz - az * bx, 0.0) / up
    nearest = np.maximum(np.maximum(a[:, 2], b[:, 2]), c[:, 2])
    base = np.where(upright, a[:, 2], nearest) - across * (a[:, 0] - 0.5) - down * (a[:, 1] - 0.5)
    return np.asarray(base[owner] + across[owner] * column + down[owner] * row)
