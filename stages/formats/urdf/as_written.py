"""The robot that a URDF describes, where its form differs from that of the robot."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from stages.formats.urdf.form import UrdfForm
from stages.formats.urdf.transmissions import with_joints
from stages.robot.inertia import merged, moved
from stages.robot.model import Array, Frame, Inertial, Joint, Link, Loop, Relation, Robot, frozen
from stages.robot.names import free
from stages.robot.start_pose import home

Holders = Mapping[str, tuple[str, Array]]
"""By link: the link that it is part of, and holder_from_link (4, 4)."""


def form_with(robot: Robot, merged: bool = False, first: Sequence[str] = ()) -> UrdfForm:
    """The form of a robot's URDF. `first`: the dofs that drive others in closed loops, where they can."""
    if not robot.loops:
        return UrdfForm(merged)
    from stages.robot.loop_lines import closed_loops, linear_couplings

    couplings = linear_couplings(robot, home(robot), first)
    return UrdfForm(merged, couplings, closed_loops(robot, couplings))


def holders(robot: Robot, form: UrdfForm) -> Holders:
    """Every link's holder: itself, or of a link on a fixed joint that is merged its parent's.

    A link `world` holds none: it has no mass in any engine, and so would what is merged into it.
    """
    found = {robot.root.name: (robot.root.name, np.eye(4))}
    for joint in robot.joints:
        holder, pose = found[joint.parent]
        merges = form.merged and not joint.dofs and holder != "world"
        found[joint.child] = (holder, pose @ joint.parent_from_joint) if merges else (joint.child, np.eye(4))
    return found


def as_written(robot: Robot, form: UrdfForm) -> Robot:
    """The robot that the URDF of this form describes: with all that was on merged links on their holders, and
    with a relation for each <mimic>."""
    robot = replace(robot, relations=_relations(robot, form))
    held = holders(robot, form)
    if all(holder == link for link, (holder, _) in held.items()):
        return robot
    groups: dict[str, list[Link]] = {}
    for link in robot.links:
        groups.setdefault(held[link.name][0], []).append(link)
    kept = [joint for joint in robot.joints if held[joint.child][0] == joint.child]
    names = {joint.name: joint.name for joint in kept}
    controls = (with_joints(text, names)[0] for text in robot.controls)
    return replace(
        robot,
        links=tuple(_merged_link(groups[link.name], held) for link in robot.links if link.name in groups),
        joints=tuple(_moved_joint(joint, held) for joint in kept),
        loops=tuple(_moved_loop(loop, held) for loop in robot.loops),
        frames=tuple(_moved_frame(frame, held) for frame in robot.frames),
        controls=tuple(text for text in controls if text),
    )


def _relations(robot: Robot, form: UrdfForm) -> tuple[Relation, ...]:
    """The robot's and those of its loops, each relative to a dof that follows no other."""
    exact = {one.follower: one for one in form.mimics}
    found = []
    for relation in robot.relations:
        via = exact.get(relation.driver)
        if via is not None:
            offset = relation.multiplier * via.offset + relation.offset
            factor = relation.multiplier * via.multiplier
            relation = replace(relation, driver=via.driver, multiplier=factor, offset=offset)
        found.append(relation)
    taken = {one.name for one in robot.relations} | {loop.name for loop in robot.loops}
    for one in form.mimics:
        name = free(f"{one.follower}_mimic", taken)
        taken.add(name)
        found.append(Relation(name, one.follower, one.driver, one.multiplier, one.offset))
    return tuple(found)


def _merged_link(links: list[Link], held: Holders) -> Link:
    """The first of the links with all that the others are. Their sum is given where that of any is."""
    first, poses = links[0], [held[link.name][1] for link in links]
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
