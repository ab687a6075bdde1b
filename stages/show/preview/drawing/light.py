"""Light from many far lamps: a soft key light and a sky; what lies in whose shadow.

Each lamp has a picture of the robot as it sees it, by how near it is; a point that is behind what the lamp
sees is in its shadow. What throws shadows is a cloud of points on the robot's surface, as dense as the lamps'
pixels.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.show.preview.drawing.vectors import cross, length
from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Numbers

_KEY, _SKY = 2.1, 1.25
"""Power of the key light, and of the sky."""

_KEY_LAMPS, _SKY_LAMPS = 8, 16
_SPREAD = 0.13  # rad
_LOWEST = 0.2
"""The sine of the height above the horizon from which the sky gives light."""

_FINE, _COARSE = 0.0065, 0.01
"""The size of a pixel of what a lamp of the key light sees, and one of the sky; of the unit sphere."""

_REACH = 1.05
"""Points lie within this distance from the origin, each way."""

_MOST = 600_000
"""Points of the cloud before those in one place become one."""

_GOLDEN = np.pi * (3.0 - np.sqrt(5.0))


@dataclass(frozen=True, slots=True, eq=False)
class Lamp:
    """`direction` (3,), unit, to the lamp; its `power`; `near` (side, side): how near it is what it sees,
    -inf where there is nothing and at the edges; `lamp_from_world` (3, 3): pixels to the right and down, and
    how near; the size of a `pixel`."""

    direction: Single
    power: float
    is_key: bool
    near: Single
    lamp_from_world: Single
    pixel: float

    def reaches(self, points: Single, shift: Single, slack: float) -> npt.NDArray[np.bool_]:
        """(n,): whether its light reaches points (3, n); `shift` (2, n) [pixels] blurs the shadow's edge,
        `slack` is how many pixels behind what it sees a point is still lit."""
        side = len(self.near)
        seen = self.lamp_from_world @ points
        seen[:2] += shift
        seen[:2] += np.float32(side / 2)
        np.clip(seen[:2], 0, side - 1, out=seen[:2])
        at = seen[1].astype(np.int32)
        at *= side
        at += seen[0].astype(np.int32)
        seen[2] += np.float32(slack * self.pixel)
        return np.asarray(seen[2] >= self.near.ravel()[at])


@dataclass(frozen=True, slots=True, eq=False)
class Throwing:
    """What throws shadows: points on the robot, dense enough for the pixels of the key light, and of the
    sky."""

    fine: Single
    fine_pixel: float
    coarse: Single
    coarse_pixel: float


def throwing(corners: Single) -> Throwing:
    """What throws the shadows of triangles (m, 3, 3) within 1 of the origin."""
    cloud, pixel = _cloud(corners, _FINE)
    fine, larger = _once(cloud, pixel), max(_COARSE, 1.25 * pixel)
    return Throwing(fine, pixel, _once(fine, larger), larger)


def key_lamps(towards: Numbers, shadows: Throwing) -> list[Lamp]:
    """The lamps of the key light in the unit direction `towards` (3,): a disc of lamps, since one would throw
    hard shadows."""
    found = []
    for place in range(_KEY_LAMPS):
        tilt = _SPREAD * np.sqrt((place + 0.5) / _KEY_LAMPS)
        direction = _tilted(towards, tilt, place * _GOLDEN)
        found.append(_lamp(direction, _KEY / _KEY_LAMPS, True, shadows.fine, shadows.fine_pixel))
    return found


def sky_lamps(shadows: Throwing) -> list[Lamp]:
    """The lamps of the sky: each stands for an equal part of it, from above the horizon to the zenith."""
    found = []
    for place in range(_SKY_LAMPS):
        height = _LOWEST + (1.0 - _LOWEST) * (place + 0.5) / _SKY_LAMPS
        direction = _tilted(np.array([0.0, 0.0, 1.0]), float(np.arccos(height)), place * _GOLDEN)
        found.append(_lamp(direction, _SKY / _SKY_LAMPS, False, shadows.coarse, shadows.coarse_pixel))
    return found


def _lamp(direction: Numbers, power: float, is_key: bool, points: Single, pixel: float) -> Lamp:
    across = np.cross(direction, np.eye(3)[int(np.abs(direction).argmin())])
    across = across / np.linalg.norm(across)
    side = int(np.ceil(2 * _REACH / pixel))
    rows = np.stack([across / pixel, np.cross(direction, across) / pixel, direction])
    lamp_from_world = rows.astype(np.float32)
    right, down, near = points @ lamp_from_world.T[:, 0], points @ lamp_from_world.T[:, 1], points @ rows[2]
    at = (down + side / 2).astype(np.int32) * side + (right + side / 2).astype(np.int32)
    image = np.full(side * side, -np.inf, dtype=np.float32)
    np.maximum.at(image, at, near.astype(np.float32))
    closed = _closed(image.reshape(side, side))
    return Lamp(direction.astype(np.float32), power, is_key, closed, lamp_from_world, pixel)


def _closed(near: Single) -> Single:
    """The picture without holes of one pixel, which the cloud may leave: between two neighbours it is at
    least as near as the farther one."""
    found = near.copy()
    inner = found[1:-1, 1:-1]
    np.maximum(inner, np.minimum(near[1:-1, :-2], near[1:-1, 2:]), out=inner)
    np.maximum(inner, np.minimum(near[:-2, 1:-1], near[2:, 1:-1]), out=inner)
    return found


def _cloud(corners: Single, cell: float) -> tuple[Single, float]:
    """Points on triangles (m, 3, 3): of each its middle, and of one that is larger than a cell a grid that is
    as fine as the cells; and how large these are, which are larger where there would be too many points."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    first, second, third = (length(edge) for edge in (b - a, c - b, a - c))
    longest = np.where(first >= second, np.where(first >= third, 0, 2), np.where(second >= third, 1, 2))
    size = np.maximum(np.maximum(first, second), third)
    height = length(cross(b - a, c - a)) / np.maximum(size, np.float32(1e-12))
    while True:
        along = np.maximum(np.ceil(size / cell), 1)
        up = np.maximum(np.ceil(height / (2 * cell)), 1)
        if (along * up).sum() <= _MOST:
            break
        cell *= 1.25
    small, large = (np.flatnonzero(some) for some in (along * up == 1, along * up > 1))
    middles = (a[small] + b[small] + c[small]) * np.float32(1 / 3)
    along, up = along[large].astype(np.int32), up[large].astype(np.int32)
    number = np.repeat(np.arange(len(large)), along * up)
    within = np.arange(len(number), dtype=np.int32) - np.repeat(
        np.cumsum(along * up) - along * up, along * up
    )
    row, column = np.divmod(within, along[number])
    # The lower half of a square of which the triangle is the one side: what is beyond its edge is turned
    # back.
    u = (column + np.float32(0.5)) / along[number].astype(np.float32)
    v = (row + np.float32(0.5)) / (2 * up[number]).astype(np.float32)
    beyond = u + v > 1
    u, v = np.where(beyond, 1 - u, u), np.where(beyond, 1 - v, v)
    start, end, top = (corners[large, (longest[large] + turn) % 3] for turn in range(3))
    points = start[number]
    points += u[:, None] * (end - start)[number]
    points += v[:, None] * (top - start)[number]
    return np.concatenate([middles, points]), cell


def _once(points: Single, cell: float) -> Single:
    """The middles of the cells of a grid that have points in them."""
    side = int(np.ceil(2 * _REACH / cell))
    cells = ((points + np.float32(_REACH)) * np.float32(1 / cell)).astype(np.int32)
    key = (cells[:, 0] * side + cells[:, 1]) * side + cells[:, 2]
    key.sort()
    key = key[np.concatenate([[True], key[1:] != key[:-1]])]
    rest, z = np.divmod(key, side)
    x, y = np.divmod(rest, side)
    return (np.stack([x, y, z], axis=1) + np.float32(0.5)) * np.float32(cell) - np.float32(_REACH)


def _tilted(towards: Numbers, tilt: float, turn: float) -> Numbers:
    """A direction tilted by an angle, about itself turned by another [rad]."""
    across = np.cross(towards, np.eye(3)[int(np.abs(towards).argmin())])
    across = across / np.linalg.norm(across)
    other = np.cross(towards, across)
    aside = np.cos(turn) * across + np.sin(turn) * other
    return np.asarray(np.cos(tilt) * towards + np.sin(tilt) * aside)
