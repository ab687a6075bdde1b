"""Carries over the content of the source's SRDF, with the robot's names."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.model.semantics import (
    NO_SEMANTICS,
    DisabledPair,
    EndEffector,
    JointGroup,
    RobotSemantics,
)


def with_semantics(robot: Robot, semantics: RobotSemantics) -> Robot:
    """Returns the robot with the SRDF's content, without entries whose links or joints the robot no longer
    has. `semantics`: the content, by the names in the source."""
    if semantics == NO_SEMANTICS:
        return robot
    # Name in the source → name: a link of the source has a path of one step, its name.
    links_by_source_name = {link.path[0]: link.name for link in robot.links if len(link.path) == 1}
    links_and_frames = links_by_source_name | {
        frame.source: frame.name for frame in robot.frames if frame.source
    }
    dofs_by_source_joint = {
        joint.mate.name: [dof.name for dof in joint.dofs if dof.kind != "free"]
        for joint in robot.joints
        if joint.mate is not None
    }
    groups = tuple(_groups(semantics, dofs_by_source_joint, links_and_frames))
    remaining = RobotSemantics(
        groups,
        tuple(_end_effectors(semantics, {group.name for group in groups}, links_and_frames)),
        tuple(dof for joint in semantics.passive for dof in dofs_by_source_joint.get(joint, ())),
        tuple(_disabled_pairs(robot, semantics, links_by_source_name)),
        semantics.virtual_joint,
    )
    return replace(robot, semantics=remaining)


def _groups(
    semantics: RobotSemantics,
    dofs_by_source_joint: Mapping[str, list[str]],
    links_and_frames: Mapping[str, str],
) -> Iterator[JointGroup]:
    """Yields the groups that still have joints."""
    for group in semantics.groups:
        joints = tuple(dof for joint in group.joints for dof in dofs_by_source_joint.get(joint, ()))
        is_chain = group.base in links_and_frames and group.tip in links_and_frames
        # A chain whose base or tip is gone stays a group of its joints.
        base, tip = (links_and_frames[group.base], links_and_frames[group.tip]) if is_chain else ("", "")
        # A group without movable joints means nothing to a planner.
        if joints:
            yield JointGroup(group.name, joints, base, tip)


def _end_effectors(
    semantics: RobotSemantics, groups: set[str], links_and_frames: Mapping[str, str]
) -> Iterator[EndEffector]:
    for effector in semantics.end_effectors:
        if effector.group in groups and effector.parent_link in links_and_frames:
            parent_group = effector.parent_group if effector.parent_group in groups else ""
            parent_link = links_and_frames[effector.parent_link]
            yield replace(effector, parent_link=parent_link, parent_group=parent_group)


def _disabled_pairs(
    robot: Robot, semantics: RobotSemantics, links_by_source_name: Mapping[str, str]
) -> Iterator[DisabledPair]:
    """Yields the pairs whose links remain, each in the order of the robot's links."""
    order = {link.name: index for index, link in enumerate(robot.links)}
    for pair in semantics.disabled:
        if pair.link_a in links_by_source_name and pair.link_b in links_by_source_name:
            a, b = sorted(
                (links_by_source_name[pair.link_a], links_by_source_name[pair.link_b]), key=order.__getitem__
            )
            yield DisabledPair(a, b, pair.reason)
