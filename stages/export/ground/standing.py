"""Places the robot in the scene: on the ground, or at the configured pose."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from linkwright.stages.export.ground.extents import Extents
from linkwright.stages.robot.errors import Diagnostic, ExportError
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.start_pose import home, roots_in_source

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.scene_section import GroundSection
    from linkwright.stages.export.section import ExportSections

MIN_NORMAL_Z = 0.1
"""Smallest vertical part of the unit normal of a ground on which a robot is put."""

MAX_DEPTH = 5e-4
"""Largest depth [m] of a link in the ground that is not reported."""

MAX_GAP = 2e-3
"""Largest distance [m] between the ground and the lowest collider of a fixed robot at which the robot keeps
its pose in CAD: a collider may be that much larger or smaller than the part."""


class Placed(Protocol):
    """Returns the root link's pose (4, 4) with the dofs at `values`, in the keyframe of this name."""

    def __call__(self, values: Configuration, keyframe: str = "") -> Array: ...


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """The pose of a robot in the scene."""

    world_from_root: Array
    """The root link's pose (4, 4) at `home`."""

    low: Array
    """The lower corner (3,) [m] of the box around the robot at `home`; infinity without shapes."""

    high: Array
    """The upper corner (3,) [m] of that box; minus infinity without shapes."""

    placed: "Placed"
    """Returns the root link's pose at other values of the dofs: a free robot with bent legs touches the
    ground with its root lower down."""

    diagnostics: tuple[Diagnostic, ...] = ()


def stand(robot: Robot, geometry: Geometry, keys: "ExportSections") -> Placement:
    """Returns the placement of the robot by the keys `scene.pose` and `ground`, or by an MJCF source with a
    ground of its own.

    Raises ExportError if the robot should touch a ground that is too steep. Reports each link that reaches
    into the ground at `home` (W-GROUND).
    """
    pose, ground = keys.scene.pose, keys.ground
    pose_of_root = from_parts(rotation_from_rpy(pose.rpy), np.array(pose.xyz))
    source_poses = roots_in_source(robot) if pose.kind == "touch" and stands_in_source(robot, keys) else {}
    pose_of_root = source_poses.get("", pose_of_root)
    touches = pose.kind == "touch" and ground.kind != "none"

    def height(extents: Extents) -> float:
        rise = _height(robot, extents, ground) if touches else 0.0
        return 0.0 if robot.base.fixed and abs(rise) <= MAX_GAP else rise

    home_values = home(robot)
    extents = _extents(robot, geometry, pose_of_root, home_values)
    rise = height(extents)
    world_from_root = _raised(pose_of_root, rise)

    def placed(values: Configuration, keyframe: str = "") -> Array:
        if source_poses:
            return source_poses.get(keyframe, world_from_root)
        is_home = all(values[dof.name] == home_values[dof.name] for dof in robot.dofs)
        if is_home or not touches or robot.base.fixed:
            return world_from_root
        return _raised(pose_of_root, height(_extents(robot, geometry, pose_of_root, values)))

    low, high = (corner + np.array([0.0, 0.0, rise]) for corner in extents.box())
    diagnostics = (
        () if ground.kind == "none" else tuple(_report_links_in_ground(robot, extents, ground, rise))
    )
    return Placement(world_from_root, low, high, placed, diagnostics)


def stands_in_source(robot: Robot, keys: "ExportSections") -> bool:
    """Returns whether the robot's MJCF source has a ground of its own that the scene keeps."""
    return robot.mjcf is not None and robot.mjcf.has_ground and keys.scene.surroundings == "keep"


def _extents(robot: Robot, geometry: Geometry, world_from_root: Array, values: Configuration) -> Extents:
    poses: Mapping[str, Array] = link_poses(robot, values)
    return Extents(geometry, {link: world_from_root @ pose for link, pose in poses.items()})


def _raised(pose: Array, height: float) -> Array:
    raised = pose.copy()
    raised[2, 3] += height
    return raised


def _normal(ground: "GroundSection") -> Array:
    normal: Array = rotation_from_rpy(ground.rpy)[:, 2]
    return normal


def _height(robot: Robot, extents: Extents, ground: "GroundSection") -> float:
    """Returns how far [m] the robot has to rise to touch the ground's plane; 0 without a shape that can."""
    normal = _normal(ground)
    if normal[2] < MIN_NORMAL_Z:
        msg = "the ground is too steep: a robot that is lowered vertically cannot stand on it"
        raise ExportError(msg, "scene.pose", "give the pose: `scene: {pose: {xyz: [0, 0, 0.5]}}`")
    links = _standing_links(robot)
    lowest = extents.min_along(links, "collision", normal)
    if not np.isfinite(lowest):
        lowest = extents.min_along(links, "visual", normal)
    if not np.isfinite(lowest):
        return 0.0
    # Meshes of single precision are not exact to a nanometre, and smaller digits differ between machines.
    return round(float((normal @ ground.xyz - lowest) / normal[2]), 9)


def _standing_links(robot: Robot) -> list[str]:
    """Returns the links that may touch the ground: all links of a free robot; the root of a fixed robot and
    the links that are rigid with it."""
    if not robot.base.fixed:
        return [link.name for link in robot.links]
    rigid = {robot.root.name}
    for joint in robot.joints:
        if joint.parent in rigid and not joint.dofs:
            rigid.add(joint.child)
    return [link.name for link in robot.links if link.name in rigid]


def _report_links_in_ground(
    robot: Robot, extents: Extents, ground: "GroundSection", height: float
) -> Iterator[Diagnostic]:
    """Reports the links whose colliders are in the ground (W-GROUND)."""
    normal = _normal(ground)
    # Links that are fixed to the world, as the ground is, do not collide with it in MuJoCo.
    rigid = set(_standing_links(robot)) if robot.base.fixed else set()
    for link in (body.name for body in robot.links if body.name not in rigid):
        lowest = extents.min_along([link], "collision", normal)
        depth = float(normal @ ground.xyz - lowest - normal[2] * height)
        if depth > MAX_DEPTH:
            yield Diagnostic(
                "W-GROUND",
                f"its collider is {1000 * depth:.3g} mm in the ground at home",
                link,
                "raise the robot (`scene: {pose: {xyz: [0, 0, ...]}}`), choose another pose "
                "(`keyframes: {home: ...}`), or move the ground (`ground: {xyz: [0, 0, ...]}`)",
            )
