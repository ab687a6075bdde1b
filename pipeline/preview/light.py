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


@dataclass(frozen=True, slots=True)
class Rig:
    """How the robot is lit: the direction to the key light, its power and half angle [rad], its lamps; the
    power of the sky and its lamps; the `side` of what a lamp sees [pixels]."""

    key: tuple[float, float, float]
    power: float = 2.1
    spread: float = 0.13
    lamps: int = 10
    sky: float = 1.25
    sky_lamps: int = 26
    side: int = 640

    @property
    def towards(self) -> Numbers:
        """(3,): the unit direction to the key light."""
        return np.asarray(np.array(self.key) / np.linalg.norm(self.key))


def lamps(rig: Rig, corners: Corners) -> list[Lamp]:
    """The lamps of a rig, and what they see of triangles (m, 3, 3) within 1 of the origin."""
    if len(corners) > _MANY:
        corners = thinned(corners, _CELL)
    found = []
    for place in range(rig.lamps):
        tilt = rig.spread * np.sqrt((place + 0.5) / rig.lamps)
        direction = _tilted(rig.towards, tilt, place * _GOLDEN)
        found.append(_lamp(direction, rig.power / rig.lamps, True, rig.side, corners))
    for place in range(rig.sky_lamps):
        # Each stands for an equal part of the sky, from low above the horizon to the zenith.
        height = 0.2 + 0.8 * (place + 0.5) / rig.sky_lamps
        direction = _tilted(np.array([0.0, 0.0, 1.0]), float(np.arccos(height)), place * _GOLDEN)
        found.append(_lamp(direction, rig.sky / rig.sky_lamps, False, rig.side // 2, corners))
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
