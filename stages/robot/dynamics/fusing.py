"""Links on fixed joints as part of the links above them: one rigid body, and no motion lost."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.robot.dynamics.inertia import merged, moved
from linkwright.stages.robot.model.poses import UNMOVED
from linkwright.stages.robot.model.robot import Array, Frame, Inertial, Joint, Link, Loop, Robot, frozen

Holders = Mapping[str, tuple[str, Array]]
"""By link: the link that it is part of, and holder_from_link (4, 4)."""


def on_fixed_joints(robot: Robot) -> tuple[str, ...]:
    """The links that can be part of the one above them.

    A link `world` holds none: it has no mass in any engine, and so would what is part of it.
    """
    return tuple(joint.child for joint in robot.joints if not joint.dofs and joint.parent != "world")


def holders(robot: Robot, parts: Collection[str]) -> Holders:
    """Every link's holder: its parent's for those that are `parts` of others, itself for the rest."""
    parts = frozenset(parts)
    found = {robot.root.name: (robot.root.name, UNMOVED)}
    for joint in robot.joints:
        holder, pose = found[joint.parent]
        fuses = joint.child in parts
        found[joint.child] = (holder, pose @ joint.parent_from_joint) if fuses else (joint.child, UNMOVED)
    return found


def members(robot: Robot, held: Holders) -> dict[str, list[tuple[str, Array]]]:
    """By holder: the links that it is made of, itself first, each with holder_from_link (4, 4)."""
    found: dict[str, list[tuple[str, Array]]] = {}
    for link in robot.links:
        holder, pose = held[link.name]
        found.setdefault(holder, []).append((link.name, pose))
    return found


def fused(robot: Robot, held: Holders) -> Robot:
    """The robot without the links that are part of others: all that was on them is on their holders."""
    links = {link.name: link for link in robot.links}
    groups = members(robot, held)
    return replace(
        robot,
        links=tuple(
            _fused_link([links[one] for one, _ in group], [pose for _, pose in group])
            for group in groups.values()
        ),
        joints=tuple(_moved_joint(one, held) for one in robot.joints if held[one.child][0] == one.child),
        loops=tuple(_moved_loop(loop, held) for loop in robot.loops),
        frames=tuple(_moved_frame(frame, held) for frame in robot.frames),
    )


def _fused_link(links: Sequence[Link], poses: Sequence[Array]) -> Link:
    """The first of the links with all that the others are. Their sum is given where that of any is."""
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
    given: Inertial | None = None
    if any(link.given is not None or not link.parts for link in links):
        given = inertial
    parts = tuple(sorted(parts, key=lambda part: part.path))
    return replace(first, inertial=inertial, parts=parts, given=given, shapes=shapes)


def _moved_joint(joint: Joint, held: Holders) -> Joint:
    holder, pose = held[joint.parent]
    return replace(joint, parent=holder, parent_from_joint=frozen(pose @ joint.parent_from_joint))


def _moved_loop(loop: Loop, held: Holders) -> Loop:
    (a, a_pose), (b, b_pose) = held[loop.link_a], held[loop.link_b]
    frames = frozen(a_pose @ loop.a_from_frame), frozen(b_pose @ loop.b_from_frame)
    return replace(loop, link_a=a, link_b=b, a_from_frame=frames[0], b_from_frame=frames[1])


def _moved_frame(frame: Frame, held: Holders) -> Frame:
    holder, pose = held[frame.link]
    return replace(frame, link=holder, link_from_frame=frozen(pose @ frame.link_from_frame))
