"""Places the camera so that the whole robot is in the picture, and projects points."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.show.raster import Numbers

_VERTICAL_ANGLE = 28.0
"""Vertical angle of view [deg]; smaller than in simulators, for less distortion."""

_MAX_FILLED_SHARE = 0.86
"""Share of the picture's width or height that the robot fills at most."""


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A camera with a perspective view."""

    world_from_camera: Numbers
    """The camera's right, up and backward directions in the world, as columns (3, 3)."""

    position: Numbers
    """The position (3,) [m] in the world."""

    width: int
    """The width of the picture [pixels]."""

    height: int
    """The height of the picture [pixels]."""

    focal: float
    """The focal length [pixels]."""

    def projected(self, points: Numbers) -> Numbers:
        """Projects points (..., 3): returns pixels to the right, pixels down, and nearness. Nearness is
        1/depth [1/m], since it is linear in the picture: so straight lines stay straight."""
        dtype = points.dtype
        camera_points = (points - self.position.astype(dtype)) @ self.world_from_camera.astype(dtype)
        nearness = -1.0 / camera_points[..., 2]
        camera_points[..., 0] = self.width / 2 + self.focal * camera_points[..., 0] * nearness
        camera_points[..., 1] = self.height / 2 - self.focal * camera_points[..., 1] * nearness
        camera_points[..., 2] = nearness
        return camera_points

    def rays(self, right: npt.NDArray[Any], down: npt.NDArray[Any]) -> Numbers:
        """Returns directions (..., 3) from the camera through places in the picture, each with a depth of 1
        m."""
        x, y = (right - self.width / 2) / self.focal, (self.height / 2 - down) / self.focal
        directions = np.stack([x, y, np.full_like(x, -1.0)], axis=-1)
        return np.asarray(directions @ self.world_from_camera.T)


def framing(points: Numbers, backward: Numbers, width: int, height: int) -> Camera:
    """Returns the nearest camera that has all points (n, 3) [m] in the picture.

    The camera looks against `backward` (3,), with z up. The points are in the middle of the picture, and fill
    `_MAX_FILLED_SHARE` of its height or of its width. The camera's position follows from the four planes
    through it that bound the view: each plane touches the points that are farthest out.
    """
    axes = _axes(backward)
    focal = height / 2 / np.tan(np.radians(_VERTICAL_ANGLE) / 2)
    camera_points = points @ axes.astype(points.dtype)
    position = np.zeros(3)
    depths = []
    for axis, size in enumerate((width, height)):
        slope = _MAX_FILLED_SHARE * size / 2 / focal
        upper_extent = float((camera_points[:, axis] + slope * camera_points[:, 2]).max())
        lower_extent = float((-camera_points[:, axis] + slope * camera_points[:, 2]).max())
        position[axis] = (upper_extent - lower_extent) / 2
        depths.append((upper_extent + lower_extent) / (2 * slope))
    position[2] = max(depths)
    return Camera(axes, axes @ position, width, height, float(focal))


def turned_about_z(camera_backward: Numbers, angle: float) -> Numbers:
    """Turns a direction about z by an `angle` [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y, z = camera_backward
    return np.array([cos * x - sin * y, sin * x + cos * y, z])


def _axes(backward: Numbers) -> Numbers:
    """Returns the camera's right, up and backward directions in the world as columns (3, 3)."""
    back = backward / np.linalg.norm(backward)
    right = np.cross([0.0, 0.0, 1.0], back)
    if np.linalg.norm(right) < 1e-6:
        right = np.array([1.0, 0.0, 0.0])
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back], axis=1)
