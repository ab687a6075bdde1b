"""Where the scene puts the robot: on the ground, or where the configuration says."""

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

STEEPEST = 0.1
"""The least vertical part of the unit normal of a ground that a robot is put on."""

BELOW = 5e-4
"""How deep [m] a link of a fixed robot may be in the ground before it is reported."""


SLACK = 2e-3
"""How far [m] the lowest collider of a fixed robot may be above or below the ground with the robot where CAD
has it: a collider may be that much larger or smaller than the part."""


class Placed(Protocol):
    """Gives the root link's pose (4, 4) with the dofs at these values, in the keyframe of this name."""

    def __call__(self, values: Configuration, keyframe: str = "") -> Array: ...


@dataclass(frozen=True, slots=True, eq=False)
class Stance:
    """`world_from_root` (4, 4): the root link's pose at `home`. `low`, `high` (3,) [m]: the corners of the
    box around the robot there, infinite where it has no shapes. `placed`: the root link's pose with the dofs
    at other values, since a free robot with bent legs touches the ground with its root lower down, in the
    keyframe of this name, "" for none."""

    world_from_root: Array
    low: Array
    high: Array
    placed: "Placed"
    diagnostics: tuple[Diagnostic, ...] = ()


def stand(robot: Robot, geometry: Geometry, keys: "ExportSections") -> Stance:
    """Where the scene puts the robot, by the keys `scene.pose` and `ground`, or where an MJCF source has it
    on a ground of its own.

    ExportError where it is to touch a ground that is too steep; W-GROUND for each link that reaches into
    the ground at `home`.
    """
    pose, ground = keys.scene.pose, keys.ground
    given = from_parts(rotation_from_rpy(pose.rpy), np.array(pose.xyz))
    in_keyframes = roots_in_source(robot) if pose.kind == "touch" and stands_in_source(robot, keys) else {}
    given = in_keyframes.get("", given)
    touches = pose.kind == "touch" and ground.kind != "none"

    def height(extents: Extents) -> float:
        rise = _height(robot, extents, ground) if touches else 0.0
        return 0.0 if robot.base.fixed and abs(rise) <= SLACK else rise

    at_home = home(robot)
    extents = _extents(robot, geometry, given, at_home)
    rise = height(extents)
    world_from_root = _risen(given, rise)

    def placed(values: Configuration, keyframe: str = "") -> Array:
        if in_keyframes:
            return in_keyframes.get(keyframe, world_from_root)
        same = all(values[dof.name] == at_home[dof.name] for dof in robot.dofs)
        if same or not touches or robot.base.fixed:
            return world_from_root
        return _risen(given, height(_extents(robot, geometry, given, values)))

    low, high = (corner + np.array([0.0, 0.0, rise]) for corner in extents.box())
    found = () if ground.kind == "none" else tuple(_below(robot, extents, ground, rise))
    return Stance(world_from_root, low, high, placed, found)


def stands_in_source(robot: Robot, keys: "ExportSections") -> bool:
    """Whether the robot's MJCF source has a ground of its own, which the scene has too."""
    return robot.mjcf is not None and robot.mjcf.has_ground and keys.scene.surroundings == "keep"


def _extents(robot: Robot, geometry: Geometry, world_from_root: Array, values: Configuration) -> Extents:
    poses: Mapping[str, Array] = link_poses(robot, values)
    return Extents(geometry, {link: world_from_root @ pose for link, pose in poses.items()})


def _risen(pose: Array, height: float) -> Array:
    risen = pose.copy()
    risen[2, 3] += height
    return risen


def _normal(ground: "GroundSection") -> Array:
    normal: Array = rotation_from_rpy(ground.rpy)[:, 2]
    return normal


def _height(robot: Robot, extents: Extents, ground: "GroundSection") -> float:
    """How far [m] the robot has to rise to touch the ground's plane; 0 without a shape that can."""
    normal = _normal(ground)
    if normal[2] < STEEPEST:
        msg = "the ground is too steep for a robot that is moved along the vertical to stand on"
        raise ExportError(msg, "scene.pose", "give the pose: `scene: {pose: {xyz: [0, 0, 0.5]}}`")
    links = _standing_links(robot)
    lowest = extents.least(links, "collision", normal)
    if not np.isfinite(lowest):
        lowest = extents.least(links, "visual", normal)
    if not np.isfinite(lowest):
        return 0.0
    # Single precision meshes know no nanometres, and the digits below differ between machines.
    return round(float((normal @ ground.xyz - lowest) / normal[2]), 9)


def _standing_links(robot: Robot) -> list[str]:
    """The links that may touch the ground: all of a free robot; of a fixed one the root and all that is rigid
    with it."""
    if not robot.base.fixed:
        return [link.name for link in robot.links]
    rigid = {robot.root.name}
    for joint in robot.joints:
        if joint.parent in rigid and not joint.dofs:
            rigid.add(joint.child)
    return [link.name for link in robot.links if link.name in rigid]


def _below(robot: Robot, extents: Extents, ground: "GroundSection", height: float) -> Iterator[Diagnostic]:
    """W-GROUND for the links whose colliders are in the ground."""
    normal = _normal(ground)
    # MuJoCo lets nothing collide with the ground that is fixed to the world as that is.
    rigid = set(_standing_links(robot)) if robot.base.fixed else set()
    for link in (one.name for one in robot.links if one.name not in rigid):
        lowest = extents.least([link], "collision", normal)
        depth = float(normal @ ground.xyz - lowest - normal[2] * height)
        if depth > BELOW:
            yield Diagnostic(
                "W-GROUND",
                f"its collider is {1000 * depth:.3g} mm in the ground at home",
                link,
                "raise the robot (`scene: {pose: {xyz: [0, 0, ...]}}`), choose another pose "
                "(`keyframes: {home: ...}`), or move the ground (`ground: {xyz: [0, 0, ...]}`)",
            )
