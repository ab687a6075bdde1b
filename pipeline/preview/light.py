"""Light from many far lamps: a soft key light and a sky; what lies in whose shadow.

Each lamp has a picture of the robot as it sees it, by how near it is; a point that is behind what the lamp
sees is in its shadow.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeline.preview.thinning import thinned
from stages.mesh.view.raster import Corners, Numbers, nearness

Single = npt.NDArray[np.float32]
"""Half the time of double precision, and exact enough by far: a picture has a few hundred pixels."""

_KEY, _SKY = 2.1, 1.25
"""Power of the key light, and of the sky."""

_KEY_LAMPS, _SKY_LAMPS = 10, 26
_SPREAD = 0.13  # rad
_LOWEST = 0.2
"""The sine of the height above the horizon from which the sky gives light."""

_SIDE = 640
"""Of what a lamp of the key light sees [pixels]."""

_MARGIN = 2
_MANY = 40_000
"""Triangles that every lamp may look at; of more it sees a thinned robot."""

_CELL = 0.008
_GOLDEN = np.pi * (3.0 - np.sqrt(5.0))


@dataclass(frozen=True, slots=True, eq=False)
class Lamp:
    """`direction` (3,), unit, to the lamp; its `power`; `near` (side, side): how near it is what it sees,
    -inf where there is nothing and in a margin of `_MARGIN` pixels; `lamp_from_world` (3, 3): pixels to the
    right and down, and how near."""

    direction: Numbers
    power: float
    is_key: bool
    near: Single
    lamp_from_world: Single

    def reaches(self, points: Single, shift: Single, slack: float) -> npt.NDArray[np.bool_]:
        """(n,): whether its light reaches points (n, 3); `shift` (2, n) [pixels] blurs the shadow's edge,
        `slack` is how far behind what it sees a point is still lit."""
        side = len(self.near)
        right, down, near = self.lamp_from_world @ points.T
        right += shift[0] + np.float32(side / 2)
        down += shift[1] + np.float32(side / 2)
        at = np.clip(down, 0, side - 1).astype(np.int32) * np.int32(side)
        at += np.clip(right, 0, side - 1).astype(np.int32)
        near += np.float32(slack)
        return np.asarray(near >= self.near.ravel()[at])


def occluders(corners: Corners) -> Corners:
    """What throws the shadows of triangles (m, 3, 3) within 1 of the origin."""
    return thinned(corners, _CELL) if len(corners) > _MANY else corners


def key_lamps(towards: Numbers, throwing: Corners) -> list[Lamp]:
    """The lamps of the key light in the unit direction `towards` (3,), and what they see of the triangles
    `throwing` (n, 3, 3) shadows: a disc of lamps, since one would throw hard shadows."""
    found = []
    for place in range(_KEY_LAMPS):
        tilt = _SPREAD * np.sqrt((place + 0.5) / _KEY_LAMPS)
        direction = _tilted(towards, tilt, place * _GOLDEN)
        found.append(_lamp(direction, _KEY / _KEY_LAMPS, True, _SIDE, throwing))
    return found


def sky_lamps(throwing: Corners) -> list[Lamp]:
    """The lamps of the sky: each stands for an equal part of it, from above the horizon to the zenith."""
    found = []
    for place in range(_SKY_LAMPS):
        height = _LOWEST + (1.0 - _LOWEST) * (place + 0.5) / _SKY_LAMPS
        direction = _tilted(np.array([0.0, 0.0, 1.0]), float(np.arccos(height)), place * _GOLDEN)
        found.append(_lamp(direction, _SKY / _SKY_LAMPS, False, _SIDE // 2, throwing))
    return found


def _lamp(direction: Numbers, power: float, is_key: bool, side: int, corners: Corners) -> Lamp:
    across = np.cross(direction, np.eye(3)[int(np.abs(direction).argmin())])
    across = across / np.linalg.norm(across)
    inner = side - 2 * _MARGIN
    lamp_from_world = np.stack([across * inner / 2, np.cross(direction, across) * inner / 2, direction])
    placed = corners @ lamp_from_world.T
    placed[:, :, :2] += inner / 2
    near = np.pad(nearness(placed, inner), _MARGIN, constant_values=-np.inf)
    return Lamp(direction, power, is_key, near.astype(np.float32), lamp_from_world.astype(np.float32))


def _tilted(towards: Numbers, tilt: float, turn: float) -> Numbers:
    """A direction tilted by an angle, about itself turned by another [rad]."""
    across = np.cross(towards, np.eye(3)[int(np.abs(towards).argmin())])
    across = across / np.linalg.norm(across)
    other = np.cross(towards, across)
    aside = np.cos(turn) * across + np.sin(turn) * other
    return np.asarray(np.cos(tilt) * towards + np.sin(tilt) * aside)
