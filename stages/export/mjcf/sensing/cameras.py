"""Writes cameras in MJCF. Linkwright's cameras look along z, with x to the right and y down; MuJoCo's look
along −z, with y up."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.export.mjcf.placement import placement
from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.errors import Diagnostic, ExportError
from linkwright.stages.robot.model.poses import UNMOVED, from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array, Robot, frozen
from linkwright.stages.robot.model.sensing import SensorCamera
from linkwright.stages.robot.text.globs import no_match_hint

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.scene_section import CameraSection

FRAME_FROM_MUJOCO = frozen(np.diag([1.0, -1.0, -1.0, 1.0]))
"""frame_from_camera (4, 4): a camera's frame by Linkwright's convention, from the frame by MuJoCo's."""

OVERVIEW_FOVY = 45.0
"""Vertical field of view [deg] of the overview: MuJoCo's default."""

OVERVIEW_DIRECTION = np.array([1.0, -0.9, 0.6])
"""Direction from the robot to the overview camera."""


def carried_cameras(
    robot: Robot, cameras: Mapping[str, "CameraSection"]
) -> dict[str, list[tuple[str, Array]]]:
    """Returns, by link, the name and link_from_frame (4, 4) of each camera that it carries.

    Raises ExportError for a frame that the robot does not have.
    """
    if problems := unknown_frames(robot, cameras):
        raise ExportError("the cameras cannot be placed", problems=problems)
    frames = _frames(robot)
    carried: dict[str, list[tuple[str, Array]]] = {}
    for name, camera in cameras.items():
        if camera.frame is not None:
            link, link_from_frame = frames[camera.frame]
            carried.setdefault(link, []).append((name, link_from_frame))
    return carried


def unknown_frames(robot: Robot, cameras: Mapping[str, "CameraSection"]) -> list[Diagnostic]:
    """Returns a problem for each camera on a frame that the robot does not have (E-FRAME)."""
    frames = _frames(robot)
    return [
        Diagnostic(
            "E-FRAME",
            f"there is no frame or link {camera.frame!r}",
            f"scene.cameras.{name}.frame",
            no_match_hint(camera.frame, {"frames and links": frames}),
        )
        for name, camera in cameras.items()
        if camera.frame is not None and camera.frame not in frames
    ]


def _frames(robot: Robot) -> dict[str, tuple[str, Array]]:
    """Returns, by the name of a frame or link, its link and link_from_frame (4, 4)."""
    frames = {frame.name: (frame.link, frame.link_from_frame) for frame in robot.frames}
    return frames | {link.name: (link.name, UNMOVED) for link in robot.links}


def write_camera(parent: Element, name: str, camera: "CameraSection", parent_from_frame: Array) -> None:
    """Writes a camera under the element of a body or the world. `parent_from_frame` (4, 4): the pose of the
    camera's frame in that element."""
    position = np.array(camera.xyz)
    rotation = rotation_from_rpy(camera.rpy)
    if camera.look_at is not None:
        rotation = _look_along(np.array(camera.look_at) - position)
    pose = parent_from_frame @ from_parts(rotation, position) @ FRAME_FROM_MUJOCO
    _write_camera_element(parent, name, pose, camera.fovy, camera.resolution)


def write_sensor_camera(parent: Element, parent_from_camera: Array, camera: SensorCamera) -> Element:
    """Writes a sensor's camera under the element of a body. `parent_from_camera` (4, 4): its pose in that
    element."""
    pose = parent_from_camera @ FRAME_FROM_MUJOCO
    return _write_camera_element(parent, camera.name, pose, camera.fovy, camera.resolution)


def write_overview(world: Element, center: Array, radius: float) -> None:
    """Writes a camera that sees the whole sphere with this `radius` [m] around `center` (3,)."""
    direction = OVERVIEW_DIRECTION / np.linalg.norm(OVERVIEW_DIRECTION)
    # A tenth more than the distance at which the sphere just fits into the view.
    distance = 1.1 * max(radius, 1e-3) / np.sin(np.radians(OVERVIEW_FOVY) / 2)
    position = np.round(center + direction * distance, 3)
    pose = from_parts(_look_along(center - position), position) @ FRAME_FROM_MUJOCO
    _write_camera_element(world, "overview", pose, OVERVIEW_FOVY, None)


def _write_camera_element(
    parent: Element, name: str, pose: Array, fovy: float, resolution: Collection[int] | None
) -> Element:
    """Writes a camera at a pose (4, 4) in `parent`, with MuJoCo's axes, and returns its element. `fovy`: its
    vertical field of view [deg]; `resolution`: width and height [pixels]."""
    size = None if resolution is None else " ".join(map(str, resolution))
    return element(parent, "camera", name=name, **placement(pose), fovy=number(fovy), resolution=size)


def _look_along(direction: Array) -> Array:
    """Returns the rotation (3, 3) whose z axis is along `direction`, and whose y axis points down as far as
    possible."""
    z = direction / np.linalg.norm(direction)
    down = np.array([0.0, 0.0, -1.0])
    if np.linalg.norm(np.cross(down, z)) < 1e-9:
        down = np.array([-1.0, 0.0, 0.0])
    x = np.cross(down, z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
