"""Lights the robot with many far lamps, a soft key light and a sky, and casts its shadows.

Each lamp has a picture of the robot from its direction, with the nearness of each pixel (a shadow map); a
point behind the nearness of its pixel is in the shadow. Shadows are cast by a cloud of points on the robot's
surface, as dense as the lamps' pixels.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.show.preview.drawing.vectors import cross, lengths_of
from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Numbers

_KEY_POWER, _SKY_POWER = 2.1, 1.25
"""Power of the key light, and of the sky."""

_KEY_LAMPS, _SKY_LAMPS = 8, 16
"""Number of lamps of the key light, and of the sky."""

_MAX_KEY_ANGLE = 0.13
"""Largest angle [rad] between a key lamp and the direction of the key light."""

_MIN_SKY_HEIGHT = 0.2
"""Sine of the elevation from which the sky gives light, up to the zenith."""

_KEY_PIXEL, _SKY_PIXEL = 0.0065, 0.01
"""The size of a pixel of a key lamp's picture, and of a sky lamp's, in radii of the robot."""

_MAX_COORDINATE = 1.05
"""Largest absolute coordinate of a point; the robot is scaled to a radius of 1."""

_MAX_POINTS = 600_000
"""Largest number of points of the cloud, before points in the same cell are merged."""

_GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))
"""The golden angle [rad]: points at its multiples are spread evenly, as on a sunflower."""


@dataclass(frozen=True, slots=True, eq=False)
class Lamp:
    """A lamp, infinitely far away, with its shadow map."""

    direction: Single
    """Unit vector (3,) towards the lamp."""

    power: float
    is_key: bool
    near: Single
    """The nearness (side, side) of the robot in each pixel; -inf without the robot and at the edges."""

    lamp_from_world: Single
    """Matrix (3, 3) from world coordinates to pixels to the right, pixels down, and nearness."""

    pixel: float
    """The size of a pixel, in radii of the robot."""

    def reaches(self, points: Single, shift: Single, slack: float) -> npt.NDArray[np.bool_]:
        """Tells for each of the points (3, n) whether the lamp's light reaches it. `shift` (2, n) [pixels]: a
        shift that blurs the shadow's edge; `slack`: the depth [pixels] behind the nearest point up to which
        points are still lit."""
        side = len(self.near)
        seen = self.lamp_from_world @ points
        seen[:2] += shift
        seen[:2] += np.float32(side / 2)
        np.clip(seen[:2], 0, side - 1, out=seen[:2])
        index = seen[1].astype(np.int32)
        index *= side
        index += seen[0].astype(np.int32)
        seen[2] += np.float32(slack * self.pixel)
        return np.asarray(seen[2] >= self.near.ravel()[index])


@dataclass(frozen=True, slots=True, eq=False)
class ShadowCasters:
    """Points on the robot that cast shadows."""

    fine: Single
    """Points as dense as the pixels of the key lamps."""

    fine_pixel: float
    """The size of a pixel of the key lamps."""

    coarse: Single
    """Points as dense as the pixels of the sky lamps."""

    coarse_pixel: float
    """The size of a pixel of the sky lamps."""


def shadow_casters(corners: Single) -> ShadowCasters:
    """Returns the points that cast the shadows of triangles (m, 3, 3) within 1 of the origin."""
    cloud, pixel = _cloud(corners, _KEY_PIXEL)
    fine, coarse_pixel = _cell_centres(cloud, pixel), max(_SKY_PIXEL, 1.25 * pixel)
    return ShadowCasters(fine, pixel, _cell_centres(fine, coarse_pixel), coarse_pixel)


def key_lamps(towards: Numbers, shadows: ShadowCasters) -> list[Lamp]:
    """Returns the lamps of the key light in the unit direction `towards` (3,): a disc of lamps, since a
    single lamp would cast hard shadows."""
    lamps = []
    for index in range(_KEY_LAMPS):
        tilt = _MAX_KEY_ANGLE * np.sqrt((index + 0.5) / _KEY_LAMPS)
        direction = _tilted(towards, tilt, index * _GOLDEN_ANGLE)
        lamps.append(_lamp(direction, _KEY_POWER / _KEY_LAMPS, True, shadows.fine, shadows.fine_pixel))
    return lamps


def sky_lamps(shadows: ShadowCasters) -> list[Lamp]:
    """Returns the lamps of the sky, each for an equal share of the sky's area above `_MIN_SKY_HEIGHT`."""
    lamps = []
    for index in range(_SKY_LAMPS):
        height = _MIN_SKY_HEIGHT + (1.0 - _MIN_SKY_HEIGHT) * (index + 0.5) / _SKY_LAMPS
        direction = _tilted(np.array([0.0, 0.0, 1.0]), float(np.arccos(height)), index * _GOLDEN_ANGLE)
        lamps.append(_lamp(direction, _SKY_POWER / _SKY_LAMPS, False, shadows.coarse, shadows.coarse_pixel))
    return lamps


def _lamp(direction: Numbers, power: float, is_key: bool, points: Single, pixel: float) -> Lamp:
    side_axis = np.cross(direction, np.eye(3)[int(np.abs(direction).argmin())])
    side_axis = side_axis / np.linalg.norm(side_axis)
    side = int(np.ceil(2 * _MAX_COORDINATE / pixel))
    rows = np.stack([side_axis / pixel, np.cross(direction, side_axis) / pixel, direction])
    lamp_from_world = rows.astype(np.float32)
    right, down, near = points @ lamp_from_world.T[:, 0], points @ lamp_from_world.T[:, 1], points @ rows[2]
    index = (down + side / 2).astype(np.int32) * side + (right + side / 2).astype(np.int32)
    image = np.full(side * side, -np.inf, dtype=np.float32)
    np.maximum.at(image, index, near.astype(np.float32))
    filled = _without_holes(image.reshape(side, side))
    return Lamp(direction.astype(np.float32), power, is_key, filled, lamp_from_world, pixel)


def _without_holes(near: Single) -> Single:
    """Fills holes of a pixel, which the cloud of points may leave: between two neighbours the picture becomes
    at least as near as the farther of them."""
    filled = near.copy()
    inner = filled[1:-1, 1:-1]
    np.maximum(inner, np.minimum(near[1:-1, :-2], near[1:-1, 2:]), out=inner)
    np.maximum(inner, np.minimum(near[:-2, 1:-1], near[2:, 1:-1]), out=inner)
    return filled


def _cloud(corners: Single, cell: float) -> tuple[Single, float]:
    """Returns points on triangles (m, 3, 3), and the size of the cells, which grows if there would be too
    many points. A triangle smaller than a cell gets a point in its middle, a larger one a grid of points, so
    that there are at least as many points as triangles."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    edge_ab, edge_bc, edge_ca = (lengths_of(edge) for edge in (b - a, c - b, a - c))
    longest = np.where(
        edge_ab >= edge_bc, np.where(edge_ab >= edge_ca, 0, 2), np.where(edge_bc >= edge_ca, 1, 2)
    )
    size = np.maximum(np.maximum(edge_ab, edge_bc), edge_ca)
    height = lengths_of(cross(b - a, c - a)) / np.maximum(size, np.float32(1e-12))
    most = max(_MAX_POINTS, len(corners))
    while True:
        along = np.maximum(np.ceil(size / cell), 1)
        up = np.maximum(np.ceil(height / (2 * cell)), 1)
        if (along * up).sum() <= most:
            break
        cell *= 1.25
    small, large = (np.flatnonzero(indices) for indices in (along * up == 1, along * up > 1))
    middles = (a[small] + b[small] + c[small]) * np.float32(1 / 3)
    along, up = along[large].astype(np.int32), up[large].astype(np.int32)
    number = np.repeat(np.arange(len(large)), along * up)
    rank = np.arange(len(number), dtype=np.int32) - np.repeat(np.cumsum(along * up) - along * up, along * up)
    row, column = np.divmod(rank, along[number])
    # The lower half of a square with the triangle on one side of its diagonal: points beyond it are reflected
    # back.
    u = (column + np.float32(0.5)) / along[number].astype(np.float32)
    v = (row + np.float32(0.5)) / (2 * up[number]).astype(np.float32)
    is_beyond = u + v > 1
    u, v = np.where(is_beyond, 1 - u, u), np.where(is_beyond, 1 - v, v)
    start, end, top = (corners[large, (longest[large] + turn) % 3] for turn in range(3))
    points = start[number]
    points += u[:, None] * (end - start)[number]
    points += v[:, None] * (top - start)[number]
    return np.concatenate([middles, points]), cell


def _cell_centres(points: Single, cell: float) -> Single:
    """Returns the centres of the cells of a grid that contain points."""
    side = int(np.ceil(2 * _MAX_COORDINATE / cell))
    cells = ((points + np.float32(_MAX_COORDINATE)) * np.float32(1 / cell)).astype(np.int32)
    key = (cells[:, 0] * side + cells[:, 1]) * side + cells[:, 2]
    key.sort()
    key = key[np.concatenate([[True], key[1:] != key[:-1]])]
    rest, z = np.divmod(key, side)
    x, y = np.divmod(rest, side)
    return (np.stack([x, y, z], axis=1) + np.float32(0.5)) * np.float32(cell) - np.float32(_MAX_COORDINATE)


def _tilted(towards: Numbers, tilt: float, turn: float) -> Numbers:
    """Tilts a direction by the angle `tilt` [rad], towards a side that `turn` [rad] chooses."""
    side_axis = np.cross(towards, np.eye(3)[int(np.abs(towards).argmin())])
    side_axis = side_axis / np.linalg.norm(side_axis)
    third = np.cross(towards, side_axis)
    aside = np.cos(turn) * side_axis + np.sin(turn) * third
    return np.asarray(np.cos(tilt) * towards + np.sin(tilt) * aside)
