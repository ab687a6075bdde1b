"""Rasterizes triangles: each pixel shows the triangle nearest to the viewer."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

Corners = npt.NDArray[np.floating[Any]]
"""Corners (m, 3, 3) of triangles in a picture: pixels to the right, pixels down, and nearness to the
viewer."""
Pixels = npt.NDArray[np.uint8]
"""Pixels (height, width, 3) as red, green and blue, the first row at the top."""
Numbers = npt.NDArray[np.floating[Any]]
Indices = npt.NDArray[np.integer[Any]]

_MAX_BATCH = 1 << 21
"""Number of pixels that are tested at once, which limits the memory."""

_LEVELS = 1 << 20
"""Number of levels of depth."""

_TRIANGLE_BITS = 26
"""Lower bits of a pixel's entry, with the triangle's index; the upper bits hold the level of depth, so that
the largest entry is the nearest triangle."""

_MAX_EDGE_ON_AREA = 1e-3
"""Triangles whose visible area, doubled, is at most this [pixels] count as seen edge-on."""


def work(corners: Corners) -> float:
    """Returns an upper bound of the number of pixels that are tested to draw the triangles."""
    return float(_boxes(corners).sum())


def picture_of_triangles(corners: Corners, colours: Pixels, background: Pixels, side: int) -> Pixels:
    """Returns the picture, `side` pixels high and wide. A pixel has the colour of the nearest triangle that
    contains its centre, else that of the `background` (3,). `colours` (m, 3): the colours of the triangles.
    There must be fewer than 2^26 triangles."""
    all_colours: Pixels = np.concatenate([colours, background[None]])
    return np.asarray(all_colours[nearest_triangles(corners, side, side)])


def nearest_triangles(corners: Corners, width: int, height: int) -> Indices:
    """Returns for each pixel (height, width) the triangle that is nearest to the viewer at its centre, or -1.

    There must be fewer than 2^26 triangles. Depth is divided into 2^20 levels; among triangles on the same
    level the last one is seen.
    """
    nearest = np.full(height * width, -1, dtype=np.int64)
    depth = corners[:, :, 2]
    low = float(depth.min(initial=np.inf))
    span = float(depth.max(initial=-np.inf)) - low
    step = _LEVELS / span if span > 0 else 0.0
    for batch in _batches(corners, _with_centres(corners)):
        triangle, row, column, near = _covered_pixels(corners[batch], width, height)
        entry = np.clip((near - low) * step, 0, _LEVELS).astype(np.int64)
        entry <<= _TRIANGLE_BITS
        entry |= batch[triangle]
        row *= width
        row += column
        np.maximum.at(nearest, row, entry)
    no_triangle = (1 << _TRIANGLE_BITS) - 1
    nearest &= no_triangle
    triangles = nearest.astype(np.int32)
    triangles[triangles == no_triangle] = -1
    return triangles.reshape(height, width)


def _boxes(corners: Corners) -> Numbers:
    """Returns the number (m,) of pixels in the box around each triangle."""
    a, b, c = np.moveaxis(corners[:, :, :2], 1, 0)
    # By pairs: reducing an axis of three takes several times as long.
    size = np.maximum(np.maximum(a, b), c) - np.minimum(np.minimum(a, b), c) + 1.0
    return np.asarray(size[:, 0] * size[:, 1])


def _with_centres(corners: Corners) -> Indices:
    """Returns the triangles whose box contains the centre of a pixel."""
    contains = np.ones(len(corners), dtype=np.bool_)
    for axis in range(2):
        a, b, c = np.moveaxis(corners[:, :, axis] - 0.5, 1, 0)
        contains &= np.floor(np.maximum(np.maximum(a, b), c)) >= np.minimum(np.minimum(a, b), c)
    return np.flatnonzero(contains)


def _batches(corners: Corners, triangle_indices: Indices) -> Iterator[Indices]:
    """Yields batches of triangles whose pixels fit into memory."""
    batch = (np.cumsum(_boxes(corners[triangle_indices])) // _MAX_BATCH).astype(np.int64)
    yield from np.split(triangle_indices, np.flatnonzero(np.diff(batch)) + 1)


def _covered_pixels(corners: Corners, width: int, height: int) -> tuple[Indices, Indices, Indices, Numbers]:
    """Returns, for each pixel whose centre is in a triangle, in arrays (n,): the triangle, the pixel's
    row and column, and the triangle's nearness to the viewer there.

    Each row of pixels is filled between the places where it enters and leaves the triangle.
    """
    top, middle, bottom = _downwards(corners)
    owner, row = _pixels_between(top[1], bottom[1], height)
    y = row + corners.dtype.type(0.5)
    long_edge_x = _Edge(top, bottom).at(owner, y)
    short_edges_x = np.where(
        y < middle[1][owner], _Edge(top, middle).at(owner, y), _Edge(middle, bottom).at(owner, y)
    )
    span, column = _pixels_between(
        np.minimum(long_edge_x, short_edges_x), np.maximum(long_edge_x, short_edges_x), width
    )
    owner, row = owner[span], row[span]
    return owner, row, column, _nearness(corners, owner, column, row)


Places = tuple[Numbers, Numbers]


def _downwards(corners: Corners) -> tuple[Places, Places, Places]:
    """Returns the places of the corners of each triangle, from the highest to the lowest corner."""
    a, b, c = ((corners[:, corner, 0], corners[:, corner, 1]) for corner in range(3))
    a, b = _sorted_by_height(a, b)
    b, c = _sorted_by_height(b, c)
    a, b = _sorted_by_height(a, b)
    return a, b, c


def _sorted_by_height(start: Places, end: Places) -> tuple[Places, Places]:
    """Returns both places, the higher one first."""
    is_below = start[1] > end[1]
    first, second = (
        tuple(
            np.where(is_below, second_values, first_values)
            for first_values, second_values in zip(*pair, strict=True)
        )
        for pair in ((start, end), (end, start))
    )
    return (first[0], first[1]), (second[0], second[1])


class _Edge:
    """The edges from the places `start` to `end`, downwards."""

    def __init__(self, start: Places, end: Places) -> None:
        down = end[1] - start[1]
        self._start = start
        self._slope = np.divide(end[0] - start[0], down, out=np.zeros_like(down), where=down > 0)
        self._down = down

    def at(self, edge_indices: Indices, y: Numbers) -> Numbers:
        """Returns the places where these edges cross the rows at `y`."""
        down_on_edge = np.clip(y - self._start[1][edge_indices], 0.0, self._down[edge_indices])
        return np.asarray(self._start[0][edge_indices] + down_on_edge * self._slope[edge_indices])


def _pixels_between(start: Numbers, end: Numbers, side: int) -> tuple[Indices, Indices]:
    """Returns the interval of each pixel whose centre is in an interval from `start` to `end`, and the
    pixel."""
    first = np.clip(np.ceil(start - 0.5), 0, side).astype(np.int32)
    after = np.clip(np.floor(end - 0.5) + 1, 0, side).astype(np.int32)
    count = np.maximum(after - first, 0)
    owner = np.repeat(np.arange(len(count), dtype=np.int32), count)
    # The position of each pixel in its interval, plus the first pixel of the interval.
    pixels = np.arange(len(owner), dtype=np.int32)
    pixels += (first - (np.cumsum(count) - count).astype(np.int32))[owner]
    return owner, pixels


def _nearness(corners: Corners, owner: Indices, column: Indices, row: Indices) -> Numbers:
    """Returns the nearness of the triangles `owner` at the centre of a pixel; for a triangle that is seen
    edge-on, the nearness of its nearest corner."""
    a, b, c = np.moveaxis(corners, 1, 0)
    (ax, ay, az), (bx, by, bz) = (b - a).T, (c - a).T
    up = ax * by - ay * bx
    has_area = np.abs(up) > _MAX_EDGE_ON_AREA
    up = np.where(has_area, up, 1.0)
    across = np.where(has_area, az * by - ay * bz, 0.0) / up
    down = np.where(has_area, ax * bz - az * bx, 0.0) / up
    nearest = np.maximum(np.maximum(a[:, 2], b[:, 2]), c[:, 2])
    base = np.where(has_area, a[:, 2], nearest) - across * (a[:, 0] - 0.5) - down * (a[:, 1] - 0.5)
    return np.asarray(base[owner] + across[owner] * column + down[owner] * row)
