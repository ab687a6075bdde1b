"""Places a robot in a studio: scaled to a standard size, among lamps."""

from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.show.preview.camera import turned_about_z
from linkwright.stages.show.preview.drawing.light import (
    Lamp,
    ShadowCasters,
    key_lamps,
    shadow_casters,
    sky_lamps,
)
from linkwright.stages.show.preview.drawing.pixels import light_of_srgb
from linkwright.stages.show.preview.drawing.vectors import lengths_of
from linkwright.stages.show.preview.surface import Single, Triangles
from linkwright.stages.show.raster import Numbers

_LEVELS = 64
"""Number of levels at which the space that a turning robot sweeps is measured."""

_KEY_AZIMUTH = np.radians(-22.0)
_KEY_HEIGHT = 1.6
"""Direction of the key light: the angle [rad] about z from the camera's side (negative: to the camera's
left), and the height for a horizontal distance of 1."""


@dataclass(frozen=True, slots=True, eq=False)
class LitRobot:
    """A robot among lamps."""

    surface: Triangles
    corners: Single
    """The corners (m, 3, 3) of the triangles, within 1 of the origin."""

    shadows: ShadowCasters
    backward: Numbers
    """The direction (3,) from the robot to the camera."""

    sky: list[Lamp]
    """The lamps that stay with the robot when it turns."""

    lamps: list[Lamp]
    """All lamps."""

    key: Numbers
    """The direction (3,) towards the key light."""

    floor: float
    """The height of the ground."""

    albedo: Single
    """The share (n, 3) of light of each colour that each geom reflects."""


def studio(surface: Triangles, backward: Numbers) -> LitRobot:
    """Sets up a robot of any size, to be seen from a direction."""
    points = surface.corners.reshape(-1, 3)
    low, high = (np.array([end(points[:, axis]) for axis in range(3)]) for end in (np.min, np.max))
    centre = (low + high) / 2
    centred_points = points - centre
    radius = 1.001 * float(lengths_of(centred_points).max()) or 1.0
    centred_points /= radius
    corners = centred_points.astype(np.float32).reshape(-1, 3, 3)
    floor = float(low[2] - centre[2]) / radius
    shadows = shadow_casters(corners)
    albedo = (0.018 + 0.94 * light_of_srgb(np.clip(surface.colours[:, :3], 0.0, 1.0))).astype(np.float32)
    sky = sky_lamps(shadows)
    unlit = LitRobot(surface, corners, shadows, backward, sky, [], backward, floor, albedo)
    return turned_by(unlit, 0.0)


def turned_by(scene: LitRobot, angle: float) -> LitRobot:
    """Returns the robot turned by an angle [rad] before a camera and a key light that keep their places."""
    backward = turned_about_z(scene.backward, -angle)
    horizontal = np.array([backward[0], backward[1], 0.0])
    horizontal_length = float(np.linalg.norm(horizontal))
    front = horizontal / horizontal_length if horizontal_length > 1e-6 else np.array([1.0, 0.0, 0.0])
    # From above, and from the left of the camera, but not so far that the front is dark.
    key = turned_about_z(front, _KEY_AZIMUTH) + np.array([0.0, 0.0, _KEY_HEIGHT])
    key /= np.linalg.norm(key)
    return replace(scene, backward=backward, key=key, lamps=[*key_lamps(key, scene.shadows), *scene.sky])


def swept_points(scene: LitRobot) -> Numbers:
    """Returns points (n, 3) around the space that the robot sweeps while it turns."""
    points = scene.corners.reshape(-1, 3)
    reach = np.sqrt((points[:, :2] ** 2).sum(axis=1))
    low, high = points[:, 2].min(), points[:, 2].max()
    level = np.minimum((points[:, 2] - low) / max(high - low, 1e-12) * _LEVELS, _LEVELS - 1).astype(np.intp)
    rings = []
    for number in np.unique(level):
        at_level = level == number
        angles = np.linspace(0.0, 2 * np.pi, 72, endpoint=False)
        ring = np.stack([np.cos(angles), np.sin(angles)], axis=1) * reach[at_level].max()
        for z in (points[at_level, 2].min(), points[at_level, 2].max()):
            rings.append(np.column_stack([ring, np.full(len(ring), z)]))
    return np.concatenate(rings)
