"""Fuses links on fixed joints with the links above them; the robot moves as before."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.robot.dynamics.inertia import merged, moved
from linkwright.stages.robot.model.poses import UNMOVED
from linkwright.stages.robot.model.robot import Array, Frame, Inertial, Joint, Link, Loop, Robot, frozen

Holders = Mapping[str, tuple[str, Array]]
"""Link → its holder, the link that it is part of (or the link itself), and holder_from_link (4, 4)."""


def links_on_fixed_joints(robot: Robot) -> tuple[str, ...]:
    """Returns the links that can be part of the link above them: those on fixed joints, except on a link
    `world`, which has no mass in any engine."""
    return tuple(joint.child for joint in robot.joints if not joint.dofs and joint.parent != "world")


def holders(robot: Robot, fused_links: Collection[str]) -> Holders:
    """Returns every link's holder: that of its parent for `fused_links`, the link itself for the others."""
    fused_links = frozenset(fused_links)
    by_link = {robot.root.name: (robot.root.name, UNMOVED)}
    for joint in robot.joints:
        holder, pose = by_link[joint.parent]
        is_fused = joint.child in fused_links
        by_link[joint.child] = (
            (holder, pose @ joint.parent_from_joint) if is_fused else (joint.child, UNMOVED)
        )
    return by_link


def members(robot: Robot, holder_of: Holders) -> dict[str, list[tuple[str, Array]]]:
    """Returns the links of each holder, itself first, each with holder_from_link (4, 4)."""
    by_holder: dict[str, list[tuple[str, Array]]] = {}
    for link in robot.links:
        holder, pose = holder_of[link.name]
        by_holder.setdefault(holder, []).append((link.name, pose))
    return by_holder


def fused(robot: Robot, holder_of: Holders) -> Robot:
    """Returns the robot whose links are the holders: they have the parts, shapes, masses, joints, loops and
    frames of all their links."""
    links = {link.name: link for link in robot.links}
    groups = members(robot, holder_of)
    return replace(
        robot,
        links=tuple(
            _fused_link([links[name] for name, _ in group], [pose for _, pose in group])
            for group in groups.values()
        ),
        joints=tuple(
            _moved_joint(joint, holder_of)
            for joint in robot.joints
            if holder_of[joint.child][0] == joint.child
        ),
        loops=tuple(_moved_loop(loop, holder_of) for loop in robot.loops),
        frames=tuple(_moved_frame(frame, holder_of) for frame in robot.frames),
    )


def _fused_link(links: Sequence[Link], poses: Sequence[Array]) -> Link:
    """Returns the first of the links with the parts, shapes and mass of all of them. `poses`: first_from_link
    (4, 4) of each. The inertial is `given` if that of any link is, or if any link has no parts."""
    first = links[0]
    if len(links) == 1:
        return first
    pairs = list(zip(links, poses, strict=True))
    parts = tuple(
        replace(part, link_from_part=frozen(pose @ part.link_from_part))
        for link, pose in pairs
        for part in link.parts
    )
    shapes = tuple(
        replace(shape, link_from_shape=frozen(pose @ shape.link_from_shape))
        for link, pose in pairs
        for shape in link.shapes
    )
    inertial = merged([moved(link.inertial, pose) for link, pose in pairs])
    given_inertial: Inertial | None = None
    if any(link.given is not None or not link.parts for link in links):
        given_inertial = inertial
    parts = tuple(sorted(parts, key=lambda part: part.path))
    return replace(first, inertial=inertial, parts=parts, given=given_inertial, shapes=shapes)


def _moved_joint(joint: Joint, holder_of: Holders) -> Joint:
    holder, pose = holder_of[joint.parent]
    return replace(joint, parent=holder, parent_from_joint=frozen(pose @ joint.parent_from_joint))


def _moved_loop(loop: Loop, holder_of: Holders) -> Loop:
    (holder_a, pose_a), (holder_b, pose_b) = holder_of[loop.link_a], holder_of[loop.link_b]
    return replace(
        loop,
        link_a=holder_a,
        link_b=holder_b,
        a_from_frame=frozen(pose_a @ loop.a_from_frame),
        b_from_frame=frozen(pose_b @ loop.b_from_frame),
    )


def _moved_frame(frame: Frame, holder_of: Holders) -> Frame:
    holder, pose = holder_of[frame.link]
    return replace(frame, link=holder, link_from_frame=frozen(pose @ frame.link_from_frame))
