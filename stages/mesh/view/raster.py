"""Triangles as pixels: each point of the picture shows what is nearest to the viewer."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

Corners = npt.NDArray[np.float64]
"""(m, 3, 3): for each corner of a triangle how far to the right and down it is in the picture, in pixels, and
how far towards the viewer."""
Pixels = npt.NDArray[np.uint8]
"""(height, width, 3): red, green and blue, the first row at the top."""
Numbers = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_AT_ONCE = 1 << 21  # pixels
_LEVELS = 1 << 20
_TRIANGLE_BITS = 26
_EDGE_ON = 1e-3  # twice the area that is seen, in pixels


def work(corners: Corners) -> float:
    """How many pixels are looked at to draw them, at most."""
    return float(_boxes(corners).sum())


def drawn(corners: Corners, colours: Pixels, background: Pixels, side: int) -> Pixels:
    """The picture, `side` pixels high and wide: of each triangle (at most 2^26) its colour (m, 3) where the
    centre of a pixel is in it, and elsewhere the background (3,)."""
    every: Pixels = np.concatenate([colours, background[None]])
    return np.asarray(every[seen(corners, side, side)])


def seen(corners: Corners, width: int, height: int) -> Indices:
    """(height, width): which triangle (of at most 2^26) is nearest to the viewer at the centre of each pixel,
    -1 for none.

    Depth is cut into 2^20 levels; of triangles on one level the last one is seen.
    """
    nearest = np.full(height * width, -1, dtype=np.int64)
    depth = corners[:, :, 2]
    low = float(depth.min(initial=np.inf))
    span = float(depth.max(initial=-np.inf)) - low
    step = _LEVELS / span if span > 0 else 0.0
    for some in _batches(corners):
        triangle, row, column, near = _covered(corners[some], width, height)
        level = np.clip((near - low) * step, 0, _LEVELS).astype(np.int64)
        np.maximum.at(nearest, row * width + column, level << _TRIANGLE_BITS | some[triangle])
    found = np.where(nearest < 0, -1, nearest & ((1 << _TRIANGLE_BITS) - 1))
    return np.asarray(found.reshape(height, width))


def nearness(corners: Corners, side: int) -> Numbers:
    """(side, side): how far towards the viewer what is seen is at the centre of each pixel, -inf where there
    is nothing."""
    nearest = np.full(side * side, -np.inf)
    for some in _batches(corners):
        _, row, column, near = _covered(corners[some], side, side)
        np.maximum.at(nearest, row * side + column, near)
    return nearest.reshape(side, side)


def _boxes(corners: Corners) -> Numbers:
    """(m,): the pixels of the box around each triangle."""
    a, b, c = np.moveaxis(corners[:, :, :2], 1, 0)
    # By pairs: reducing an axis of three takes several times as long.
    size = np.maximum(np.maximum(a, b), c) - np.minimum(np.minimum(a, b), c) + 1.0
    return np.asarray(size[:, 0] * size[:, 1])


def _batches(corners: Corners) -> Iterator[Indices]:
    """The triangles, so many at a time that their pixels have room."""
    batch = (np.cumsum(_boxes(corners)) // _AT_ONCE).astype(np.int64)
    yield from np.split(np.arange(len(corners)), np.flatnonzero(np.diff(batch)) + 1)


def _covered(corners: Corners, width: int, height: int) -> tuple[Indices, Indices, Indices, Numbers]:
    """The pixels whose centres are in a triangle: which triangle, row, column, and how near the viewer it is
    there. Row by row: where a row enters and leaves a triangle."""
    downwards = np.argsort(corners[:, :, 1], axis=1, kind="stable")
    top, middle, bottom = np.moveaxis(np.take_along_axis(corners, downwards[:, :, None], axis=1), 1, 0)
    owner, row = _between(top[:, 1], bottom[:, 1], height)
    y = np.asarray(row + 0.5, dtype=np.float64)
    top, middle, bottom = top[owner], middle[owner], bottom[owner]
    upper = (y < middle[:, 1])[:, None]
    along = _crossing(top, bottom, y)
    across = _crossing(np.where(upper, top, middle), np.where(upper, middle, bottom), y)
    span, column = _between(np.minimum(along, across), np.maximum(along, across), width)
    owner, row = owner[span], row[span]
    return owner, row, column, _height(corners, owner, column, row)


def _between(start: Numbers, end: Numbers, side: int) -> tuple[Indices, Indices]:
    """The pixels of the picture with a centre within each interval, and the interval of each."""
    first = np.clip(np.ceil(start - 0.5), 0, side).astype(np.int64)
    after = np.clip(np.floor(end - 0.5) + 1, 0, side).astype(np.int64)
    count = np.maximum(after - first, 0)
    owner = np.repeat(np.arange(len(count)), count)
    within = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    return owner, first[owner] + within


def _crossing(start: Corners, end: Corners, y: Numbers) -> Numbers:
    """Where the edges from `start` to `end` cross the rows at `y`."""
    down = end[:, 1] - start[:, 1]
    share = np.divide(y - start[:, 1], down, out=np.zeros_like(y), where=down > 0)
    return np.asarray(start[:, 0] + (end[:, 0] - start[:, 0]) * np.clip(share, 0.0, 1.0))


def _height(corners: Corners, owner: Indices, column: Indices, row: Indices) -> Numbers:
    """How near the viewer the triangles `owner` are in the middle of a pixel; of one that is seen edge-on,
    its nearest point."""
    a, b, c = np.moveaxis(corners, 1, 0)
    normal = np.cross(b - a, c - a)
    upright = np.abs(normal[:, 2]) > _EDGE_ON
    across, down, up = (
        np.where(upright, axis, other) for axis, other in zip(normal.T, (0.0, 0.0, 1.0), strict=True)
    )
    nearest = np.maximum(np.maximum(a[:, 2], b[:, 2]), c[:, 2])
    across, down = -across / up, -down / up
    base = np.where(upright, a[:, 2], nearest) - across * (a[:, 0] - 0.5) - down * (a[:, 1] - 0.5)
    return np.asarray(base[owner] + across[owner] * column + down[owner] * row)
