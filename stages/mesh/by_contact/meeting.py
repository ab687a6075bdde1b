"""Which links meet the world: with these the robot grasps, stands and touches."""

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
from linkwright.stages.robot.text.globs import fits, there_are

_NAMED = re.compile(r"foot|tool|grasp|grip|tcp|tip|end_?effector|(^|_)ee($|_)", re.IGNORECASE)
"""Names of frames by which a robot meets the world."""

_POINTS = 400
_OFTEN = 0.1
_MUCH = 0.02
"""A link moves in its parent's hollow where, in more than a tenth of the poses, more than a fiftieth of its
points are within the parent's hull and away from its surface."""

_LEVEL = 0.05
"""As a share of a robot's height: what is higher up by less than this stands on the same ground."""


def ends_of_chains(robot: Robot, solid: Collection[str]) -> list[str]:
    """The links with a collider (`solid`) that nothing with a collider hangs on, and those with a frame that
    is named for it. What turns without limits stays round, and what closes a loop holds another link."""
    carries: set[str] = set()
    holds = {joint.child: joint for joint in robot.joints}
    for name in solid:
        above = holds.get(name)
        while above is not None and above.parent not in carries:
            carries.add(above.parent)
            above = holds.get(above.parent)
    looped = {link for loop in robot.loops for link in (loop.link_a, loop.link_b)}
    named = {frame.link for frame in robot.frames if _NAMED.search(frame.name)}
    return [
        link.name
        for link in robot.links
        if link.name in solid
        and (
            link.name in named
            or (
                link.name in holds
                and link.name not in carries
                and link.name not in looped
                and not _spins(holds[link.name])
            )
        )
    ]


def _spins(joint: Joint) -> bool:
    return any(dof.kind == "turn" and dof.limits.lower is None for dof in joint.dofs)


def with_jaws(
    robot: Robot,
    ends: Collection[str],
    surfaces: Mapping[str, Surface],
    hulls: Mapping[str, Surface],
    poses: Mapping[str, Array],
    tolerances: Mapping[str, float],
) -> set[str]:
    """The ends, and those parents of ends whose hull would fill the hollow in which the end moves, as that of
    the fixed jaw of a gripper: parent and child never collide, so that no pair of links shows it. What a
    robot stands on is no finger.

    `surfaces`, `hulls`: by link, of those that get colliders by contact; `poses` (n, 4, 4): root_from_link,
    at `home` first; `tolerances` [m].
    """
    found = set(ends)
    fingers = found - _feet(robot, surfaces, poses)
    for joint in robot.joints:
        child, parent = joint.child, joint.parent
        if child in fingers and parent in hulls and parent not in found and joint.dofs:
            places = relative(poses[parent], poses[child])[:: max(1, len(poses[child]) // 64)]
            if _fills(surfaces[child], surfaces[parent], hulls[parent], places, tolerances[parent]):
                found.add(parent)
    return found


def _feet(robot: Robot, surfaces: Mapping[str, Surface], poses: Mapping[str, Array]) -> set[str]:
    """The links on which a free robot stands at `home`: those that reach as far down as any."""
    if robot.base.fixed:
        return set()
    places = {link: robot.world_from_root @ poses[link][0] for link in surfaces}
    heights = {
        link: surface.vertices @ places[link][2, :3] + places[link][2, 3]
        for link, surface in surfaces.items()
    }
    lowest = min(float(points.min()) for points in heights.values())
    tall = max(float(points.max()) for points in heights.values()) - lowest
    return {link for link, points in heights.items() if points.min() <= lowest + _LEVEL * tall}


def _fills(child: Surface, parent: Surface, hull: Surface, places: Array, tolerance: float) -> bool:
    points = child.vertices[:: max(1, len(child.vertices) // _POINTS)]
    normals, heights = half_spaces(hull)
    nearest = Nearest.of(BoxTree.of(parent))
    often = 0
    for place in places:
        here = points @ place[:3, :3].T + place[:3, 3]
        deep = beyond(normals, heights, here) < -tolerance
        if deep.mean() > _MUCH:
            often += bool(np.count_nonzero(nearest(here[deep])[0] > tolerance) > _MUCH * len(points))
    return often > _OFTEN * len(places)


def wanted(fine: str | Sequence[str], links: Sequence[Link], log: Diagnostics) -> set[str] | None:
    """The links that `mesh.fine` names; None where it leaves that to the robot. E-GLOB for each glob that
    matches no link."""
    if isinstance(fine, str):
        return None if fine == "auto" else {link.name for link in links}
    for glob in fine:
        if not any(fits(link.name, glob) for link in links):
            hint = there_are(glob, {"links": [link.name for link in links]})
            log.unmatched("E-GLOB", f"no link matches {glob!r}", "mesh.fine", hint, glob)
    return {link.name for link in links if any(fits(link.name, glob) for glob in fine)}
