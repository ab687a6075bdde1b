"""Finds where a file's kinematics differs from the robot's: the first such elements of the tree.

Each link is compared relative to its parent, so that errors above it do not count for it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Dof, Joint
from linkwright.stages.validate.findings import differs, few, largest_error, offset_and_angle, pose_findings
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE, distance
from linkwright.stages.validate.same.read_robot import Poses, ReadRobot


@dataclass(frozen=True, slots=True, eq=False)
class PosePair:
    """The poses of the file and of the robot, at the same values of the dofs."""

    actual: Poses
    expected: Poses


def differences(read: ReadRobot, pairs: Sequence[PosePair]) -> tuple[Finding, ...]:
    """Returns findings on joints, links and frames whose pose relative to their parent is not the robot's,
    parents first. `pairs`: the poses at the file's own placement or at zero, then at spread values."""
    return few([*_joints(read, pairs), *_frames(read, pairs[0].actual)])


def _joints(read: ReadRobot, pairs: Sequence[PosePair]) -> Iterator[Finding]:
    for joint in read.robot.joints:
        relative = [
            tuple(_on_parent(joint, poses) for poses in (pair.actual, pair.expected)) for pair in pairs
        ]
        if all(distance(*pair) <= read.precision.pose for pair in relative):
            continue
        parent = read.parent(joint.child)
        if parent != joint.parent:
            yield differs(read.placed(joint), "parent", parent or "none of the robot's links", joint.parent)
        else:
            yield from _of_joint(read, joint, relative)


def _on_parent(joint: Joint, poses: Poses) -> Array:
    return inverse(poses.links[joint.parent]) @ poses.links[joint.child]


def _of_joint(read: ReadRobot, joint: Joint, pairs: list[tuple[Array, ...]]) -> Iterator[Finding]:
    """Reports a joint's error: an error of its axis or place if the child moves wrongly from its start, else
    an error of the child's start."""
    words, least = read.attribute_names, read.precision.pose
    (rest, expected_rest), *spread = pairs
    errors = [
        offset_and_angle(inverse(rest) @ pose, inverse(expected_rest) @ expected_pose)
        for pose, expected_pose in spread
    ]
    scalars = [dof for dof in joint.dofs if dof.kind in ("turn", "slide")]
    if joint.dofs and largest_error(value for pair in errors for value in pair) > least:
        dof = next((scalar for scalar in scalars if not _same_axis(read, joint, scalar)), joint.dofs[0])
        element, axis = read.element("joint", dof.name), read.axis(dof)
        is_turned = largest_error(angle for _, angle in errors) > least
        if axis is None:
            attributes = f"{words.place[0]}, {words.axis}"
            yield Finding(element, attributes, "moves its child differently than the robot's")
        elif dof.kind == "slide" or (dof.kind == "turn" and is_turned):
            yield differs(element, words.axis, axis, dof.axis)
        elif is_turned:
            yield Finding(element, words.place[1], "turns differently than the robot's")
        else:
            yield Finding(element, words.place[0], "is not where the robot's axis is")
        return
    for dof in scalars:
        zero = read.zero(dof)
        if zero is not None and not abs(zero[0] - zero[1]) <= ENGINE_TOLERANCE * max(1.0, abs(zero[1])):
            yield differs(read.element("joint", dof.name), words.zero, *zero)
            return
    yield from pose_findings(read.placed(joint), rest, expected_rest, words.place, least)


def _same_axis(read: ReadRobot, joint: Joint, dof: Dof) -> bool:
    """Tells whether the file's axis is that of the dof. Only a child's last joint is surely in the axes of
    the child."""
    axis = read.axis(dof)
    return len(joint.dofs) > 1 or axis is None or float(np.abs(axis - dof.axis).max()) <= ENGINE_TOLERANCE


def _frames(read: ReadRobot, poses: Poses) -> Iterator[Finding]:
    for frame in read.robot.frames:
        if frame.name not in poses.frames:
            continue
        pose = inverse(poses.links[frame.link]) @ poses.frames[frame.name]
        element = read.element("frame", frame.name)
        if np.isnan(pose).any():
            yield Finding(element, "name", "is missing")
        elif not distance(pose, frame.link_from_frame) <= ENGINE_TOLERANCE:
            yield from pose_findings(
                element, pose, frame.link_from_frame, read.attribute_names.place, ENGINE_TOLERANCE
            )
