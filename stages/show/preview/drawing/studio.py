"""A robot in a studio: of one size whatever its own, among lamps."""

from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.show.preview.camera import turned
from linkwright.stages.show.preview.drawing.light import Lamp, Throwing, key_lamps, sky_lamps, throwing
from linkwright.stages.show.preview.drawing.pixels import linear
from linkwright.stages.show.preview.drawing.vectors import length
from linkwright.stages.show.preview.surface import Single, Triangles
from linkwright.stages.show.raster import Numbers

_LEVELS = 64
_KEY_ASIDE = np.radians(-22.0)
_KEY_ABOVE = 1.6
"""Where the key light is: to the left of the camera, and above, of 1 towards it."""


@dataclass(frozen=True, slots=True, eq=False)
class LitRobot:
    """A robot, its `corners` (m, 3, 3) within 1 of the origin, seen from `backward` (3,), with its `lamps`,
    of which the key light is towards `key` (3,). `sky`: the lamps that stay where they are while the robot
    turns; `floor`: the height of the ground; `albedo` (n, 3) of each geom."""

    surface: Triangles
    corners: Single
    shadows: Throwing
    backward: Numbers
    sky: list[Lamp]
    lamps: list[Lamp]
    key: Numbers
    floor: float
    albedo: Single


def studio(surface: Triangles, backward: Numbers) -> LitRobot:
    """Sets a robot up, whatever its size, to be seen from a direction."""
    points = surface.corners.reshape(-1, 3)
    low, high = (np.array([end(points[:, axis]) for axis in range(3)]) for end in (np.min, np.max))
    middle = (low + high) / 2
    away = points - middle
    radius = 1.001 * float(length(away).max()) or 1.0
    away /= radius
    corners = away.astype(np.float32).reshape(-1, 3, 3)
    floor = float(low[2] - middle[2]) / radius
    shadows = throwing(corners)
    albedo = (0.018 + 0.94 * linear(np.clip(surface.colours[:, :3], 0.0, 1.0))).astype(np.float32)
    sky = sky_lamps(shadows)
    unlit = LitRobot(surface, corners, shadows, backward, sky, [], backward, floor, albedo)
    return turned_by(unlit, 0.0)


def turned_by(scene: LitRobot, angle: float) -> LitRobot:
    """The robot turned by an angle [rad] before a camera and a key light that stay where they are."""
    backward = turned(scene.backward, -angle)
    flat = np.array([backward[0], backward[1], 0.0])
    length = float(np.linalg.norm(flat))
    front = flat / length if length > 1e-6 else np.array([1.0, 0.0, 0.0])
    # From the left of the camera, little enough that the front is lit too, and above.
    key = turned(front, _KEY_ASIDE) + np.array([0.0, 0.0, _KEY_ABOVE])
    key /= np.linalg.norm(key)
    return replace(scene, backward=backward, key=key, lamps=[*key_lamps(key, scene.shadows), *scene.sky])


def swept(scene: LitRobot) -> Numbers:
    """(n, 3): points around all that the robot reaches while it turns."""
    points = scene.corners.reshape(-1, 3)
    reach = np.sqrt((points[:, :2] ** 2).sum(axis=1))
    low, high = points[:, 2].min(), points[:, 2].max()
    level = np.minimum((points[:, 2] - low) / max(high - low, 1e-12) * _LEVELS, _LEVELS - 1).astype(np.intp)
    rings = []
    for one in np.unique(level):
        some = level == one
        angles = np.linspace(0.0, 2 * np.pi, 72, endpoint=False)
        ring = np.stack([np.cos(angles), np.sin(angles)], axis=1) * reach[some].max()
        for z in (points[some, 2].min(), points[some, 2].max()):
            rings.append(np.column_stack([ring, np.full(len(ring), z)]))
    return np.concatenate(rings)
