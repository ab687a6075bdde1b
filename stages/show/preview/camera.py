"""The camera: where it stands so that all of the robot is in the picture, and what it sees there."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.show.raster import Numbers

_OPENING = 28.0
"""The angle of view, upright [deg]: a longer lens than a simulator's, which bends less."""

_FILLED = 0.86
"""The share of the picture, each way, within which the robot lies."""


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """`world_from_camera` (3, 3): its right, up and backward directions; `position` (3,) [m]; the picture's
    `width` and `height` [pixels], and `focal` length [pixels]."""

    world_from_camera: Numbers
    position: Numbers
    width: int
    height: int
    focal: float

    def projected(self, points: Numbers) -> Numbers:
        """(..., 3): pixels to the right, pixels down, and how near: 1/depth [1/m], by which straight lines
        stay straight."""
        kind = points.dtype
        seen = (points - self.position.astype(kind)) @ self.world_from_camera.astype(kind)
        near = -1.0 / seen[..., 2]
        seen[..., 0] = self.width / 2 + self.focal * seen[..., 0] * near
        seen[..., 1] = self.height / 2 - self.focal * seen[..., 1] * near
        seen[..., 2] = near
        return seen

    def rays(self, right: npt.NDArray[Any], down: npt.NDArray[Any]) -> Numbers:
        """(..., 3): directions from the camera through places in the picture, one metre deep each."""
        x, y = (right - self.width / 2) / self.focal, (self.height / 2 - down) / self.focal
        seen = np.stack([x, y, np.full_like(x, -1.0)], axis=-1)
        return np.asarray(seen @ self.world_from_camera.T)


def framing(points: Numbers, backward: Numbers, width: int, height: int) -> Camera:
    """The nearest camera that has all points (n, 3) [m] in the picture, which looks against `backward` (3,)
    with z up. They fill `_FILLED` of the picture, upright or across, and are in its middle.

    Of each of the four planes through the camera that bound the view the points that lie farthest out are
    on it: that bounds where the camera stands.
    """
    axes = _axes(backward)
    focal = height / 2 / np.tan(np.radians(_OPENING) / 2)
    seen = points @ axes.astype(points.dtype)
    place = np.zeros(3)
    depths = []
    for axis, size in enumerate((width, height)):
        slope = _FILLED * size / 2 / focal
        after = float((seen[:, axis] + slope * seen[:, 2]).max())
        before = float((-seen[:, axis] + slope * seen[:, 2]).max())
        place[axis] = (after - before) / 2
        depths.append((after + before) / (2 * slope))
    place[2] = max(depths)
    return Camera(axes, axes @ place, width, height, float(focal))


def turned(camera_backward: Numbers, angle: float) -> Numbers:
    """The direction turned about z by an `angle` [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y, z = camera_backward
    return np.array([cos * x - sin * y, sin * x + cos * y, z])


def _axes(backward: Numbers) -> Numbers:
    """(3, 3): the camera's right, up and backward directions in the world as columns."""
    back = backward / np.linalg.norm(backward)
    right = np.cross([0.0, 0.0, 1.0], back)
    if np.linalg.norm(right) < 1e-6:
        right = np.array([1.0, 0.0, 0.0])
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back], axis=1)
