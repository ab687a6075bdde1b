"""Cameras in MJCF. Ours look along z with x to the right and y down; MuJoCo's along −z with y up."""

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
from linkwright.stages.robot.text.globs import there_are

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.scene_section import CameraSection

OURS_FROM_MUJOCO = frozen(np.diag([1.0, -1.0, -1.0, 1.0]))

FOVY = 45.0
"""Vertical field of view [deg] of the overview: MuJoCo's default."""

FROM = np.array([1.0, -0.9, 0.6])
"""From where the overview looks at the robot."""


def carried_cameras(
    robot: Robot, cameras: Mapping[str, "CameraSection"]
) -> dict[str, list[tuple[str, Array]]]:
    """By link: the name and link_from_frame (4, 4) of each camera that it carries.

    ExportError for a frame that the robot does not have.
    """
    if problems := unknown_frames(robot, cameras):
        raise ExportError("the cameras cannot be placed", problems=problems)
    frames = _frames(robot)
    found: dict[str, list[tuple[str, Array]]] = {}
    for name, camera in cameras.items():
        if camera.frame is not None:
            link, link_from_frame = frames[camera.frame]
            found.setdefault(link, []).append((name, link_from_frame))
    return found


def unknown_frames(robot: Robot, cameras: Mapping[str, "CameraSection"]) -> list[Diagnostic]:
    """E-FRAME for each camera on a frame that the robot does not have."""
    frames = _frames(robot)
    return [
        Diagnostic(
            "E-FRAME",
            f"there is no frame or link {camera.frame!r}",
            f"scene.cameras.{name}.frame",
            there_are(camera.frame, {"frames and links": frames}),
        )
        for name, camera in cameras.items()
        if camera.frame is not None and camera.frame not in frames
    ]


def _frames(robot: Robot) -> dict[str, tuple[str, Array]]:
    """By name of a frame or link: its link and link_from_frame (4, 4)."""
    frames = {frame.name: (frame.link, frame.link_from_frame) for frame in robot.frames}
    return frames | {link.name: (link.name, UNMOVED) for link in robot.links}


def write_camera(above: Element, name: str, camera: "CameraSection", above_from_frame: Array) -> None:
    """A camera under the element of a body or the world, in whose axes `above_from_frame` (4, 4) is."""
    place = np.array(camera.xyz)
    turned = rotation_from_rpy(camera.rpy)
    if camera.look_at is not None:
        turned = _looking(np.array(camera.look_at) - place)
    pose = above_from_frame @ from_parts(turned, place) @ OURS_FROM_MUJOCO
    _camera(above, name, pose, camera.fovy, camera.resolution)


def write_sensor_camera(above: Element, above_from_camera: Array, camera: SensorCamera) -> Element:
    """A camera of the robot under the element of a body, in whose axes `above_from_camera` (4, 4) is."""
    pose = above_from_camera @ OURS_FROM_MUJOCO
    return _camera(above, camera.name, pose, camera.fovy, camera.resolution)


def overview(world: Element, middle: Array, radius: float) -> None:
    """A camera that sees all of the sphere of this `radius` [m] around `middle` (3,)."""
    away = FROM / np.linalg.norm(FROM)
    distance = 1.1 * max(radius, 1e-3) / np.sin(np.radians(FOVY) / 2)
    place = np.round(middle + away * distance, 3)
    pose = from_parts(_looking(middle - place), place) @ OURS_FROM_MUJOCO
    _camera(world, "overview", pose, FOVY, None)


def _camera(
    above: Element, name: str, pose: Array, fovy: float, resolution: Collection[int] | None
) -> Element:
    size = None if resolution is None else " ".join(map(str, resolution))
    return element(above, "camera", name=name, **placement(pose), fovy=number(fovy), resolution=size)


def _looking(way: Array) -> Array:
    """The rotation (3, 3) whose z axis is along `way` and whose y axis points down as far as it can."""
    z = way / np.linalg.norm(way)
    down = np.array([0.0, 0.0, -1.0])
    if np.linalg.norm(np.cross(down, z)) < 1e-9:
        down = np.array([-1.0, 0.0, 0.0])
    x = np.cross(down, z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
