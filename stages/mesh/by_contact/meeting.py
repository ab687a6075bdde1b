"""Finds the links that meet the world: those with which the robot grasps, stands and touches."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.by_contact.poses import relative
from linkwright.stages.mesh.measure import BoxTree, Nearest
from linkwright.stages.mesh.surfaces.pieces import beyond, half_spaces
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Array, Joint, Link, Robot
from linkwright.stages.robot.text.globs import matches_glob, no_match_hint

_END_NAMES = re.compile(r"foot|tool|grasp|grip|tcp|tip|end_?effector|(^|_)ee($|_)", re.IGNORECASE)
"""Names of frames at which a robot meets the world."""

_MAX_POINTS = 400
"""Number of points of a link, at most about twice this, that are tested for lying in its parent's hull."""

_MIN_POSE_SHARE = 0.1
_MIN_POINT_SHARE = 0.02
"""A link moves in a hollow of its parent if, in more than a tenth of the poses, more than a fiftieth of its
points are inside the parent's hull and away from the parent's surface."""

_MAX_HEIGHT_SHARE = 0.05
"""Largest difference in height of links that stand on the same ground, as a share of the robot's height."""


def ends_of_chains(robot: Robot, solid: Collection[str]) -> list[str]:
    """Returns the links with a collider (`solid`) that carry no other such link, and those with a frame whose
    name is in `_END_NAMES`. Of the former, links that turn without limits (wheels, which must stay round) and
    links at a loop's closure (which hold another link) are left out."""
    carriers: set[str] = set()
    joint_of = {joint.child: joint for joint in robot.joints}
    for name in solid:
        carrying_joint = joint_of.get(name)
        while carrying_joint is not None and carrying_joint.parent not in carriers:
            carriers.add(carrying_joint.parent)
            carrying_joint = joint_of.get(carrying_joint.parent)
    looped = {link for loop in robot.loops for link in (loop.link_a, loop.link_b)}
    links_with_named_frames = {frame.link for frame in robot.frames if _END_NAMES.search(frame.name)}
    return [
        link.name
        for link in robot.links
        if link.name in solid
        and (
            link.name in links_with_named_frames
            or (
                link.name in joint_of
                and link.name not in carriers
                and link.name not in looped
                and not _turns_without_limits(joint_of[link.name])
            )
        )
    ]


def _turns_without_limits(joint: Joint) -> bool:
    return any(dof.kind == "turn" and dof.limits.lower is None for dof in joint.dofs)


def with_jaws(
    robot: Robot,
    ends: Collection[str],
    surfaces: Mapping[str, Surface],
    hulls: Mapping[str, Surface],
    poses: Mapping[str, Array],
    tolerances: Mapping[str, float],
) -> set[str]:
    """Adds to the ends those of their parents whose hull would fill the hollow in which the end moves, such
    as the fixed jaw of a gripper. Parent and child never collide, so no pair of links would show that. Feet
    do not add their parents.

    `surfaces`, `hulls`: by link, for links that get colliders by contact; `poses`: root_from_link (n, 4, 4)
    by link, at `home` first; `tolerances`: by link [m].
    """
    links = set(ends)
    fingers = links - _feet(robot, surfaces, poses)
    for joint in robot.joints:
        child, parent = joint.child, joint.parent
        if child in fingers and parent in hulls and parent not in links and joint.dofs:
            relative_poses = relative(poses[parent], poses[child])[:: max(1, len(poses[child]) // 64)]
            if _fills(surfaces[child], surfaces[parent], hulls[parent], relative_poses, tolerances[parent]):
                links.add(parent)
    return links


def _feet(robot: Robot, surfaces: Mapping[str, Surface], poses: Mapping[str, Array]) -> set[str]:
    """Returns the links on which a free robot stands at `home`: those that reach down to the lowest point."""
    if robot.base.fixed:
        return set()
    world_from_link = {link: robot.world_from_root @ poses[link][0] for link in surfaces}
    heights_of_link = {
        link: surface.vertices @ world_from_link[link][2, :3] + world_from_link[link][2, 3]
        for link, surface in surfaces.items()
    }
    lowest = min(float(link_heights.min()) for link_heights in heights_of_link.values())
    height = max(float(link_heights.max()) for link_heights in heights_of_link.values()) - lowest
    highest_ground = lowest + _MAX_HEIGHT_SHARE * height
    return {link for link, link_heights in heights_of_link.items() if link_heights.min() <= highest_ground}


def _fills(child: Surface, parent: Surface, hull: Surface, poses: Array, tolerance: float) -> bool:
    """Tells whether the parent's `hull` fills a hollow in which the child moves. `poses`: parent_from_child
    (n, 4, 4); `tolerance`: smallest distance [m] of a point that counts as inside the hull and as away from
    the parent's surface."""
    points = child.vertices[:: max(1, len(child.vertices) // _MAX_POINTS)]
    normals, heights = half_spaces(hull)
    nearest = Nearest.of(BoxTree.of(parent))
    filled_poses = 0
    for pose in poses:
        moved_points = points @ pose[:3, :3].T + pose[:3, 3]
        is_deep = beyond(normals, heights, moved_points) < -tolerance
        if is_deep.mean() > _MIN_POINT_SHARE:
            filled_poses += bool(
                np.count_nonzero(nearest(moved_points[is_deep])[0] > tolerance)
                > _MIN_POINT_SHARE * len(points)
            )
    return filled_poses > _MIN_POSE_SHARE * len(poses)


def fine_links(fine: str | Sequence[str], links: Sequence[Link], log: Diagnostics) -> set[str] | None:
    """Returns the links that `mesh.fine` names; None if it is `auto`. Reports E-GLOB for each glob that
    matches no link."""
    if isinstance(fine, str):
        return None if fine == "auto" else {link.name for link in links}
    for glob in fine:
        if not any(matches_glob(link.name, glob) for link in links):
            hint = no_match_hint(glob, {"links": [link.name for link in links]})
            log.report_unmatched("E-GLOB", f"no link matches {glob!r}", "mesh.fine", hint, glob)
    return {link.name for link in links if any(matches_glob(link.name, glob) for glob in fine)}
