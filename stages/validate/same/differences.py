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


def differences(read_robot: ReadRobot, pairs: Sequence[PosePair]) -> tuple[Finding, ...]:
    """Returns findings on joints and frames that place a link or a frame, relative to its parent, elsewhere
    than the robot has it, parents first. `pairs`: the poses at the file's own placement or at zero, then at
    spread values."""
    return few([*_joint_findings(read_robot, pairs), *_frame_findings(read_robot, pairs[0].actual)])


def _joint_findings(read_robot: ReadRobot, pairs: Sequence[PosePair]) -> Iterator[Finding]:
    for joint in read_robot.robot.joints:
        parent_from_child_pairs = [
            tuple(_parent_from_child(joint, poses) for poses in (pair.actual, pair.expected))
            for pair in pairs
        ]
        if all(distance(*pair) <= read_robot.precision.pose for pair in parent_from_child_pairs):
            continue
        parent = read_robot.parent(joint.child)
        if parent != joint.parent:
            yield differs(
                read_robot.placing_element(joint),
                "parent",
                parent or "none of the robot's links",
                joint.parent,
            )
        else:
            yield from _motion_findings(read_robot, joint, parent_from_child_pairs)


def _parent_from_child(joint: Joint, poses: Poses) -> Array:
    return inverse(poses.links[joint.parent]) @ poses.links[joint.child]


def _motion_findings(
    read_robot: ReadRobot, joint: Joint, pairs: list[tuple[Array, ...]]
) -> Iterator[Finding]:
    """Reports a joint's error: an error of its axis or place if the child moves wrongly from its start, else
    an error of the child's start. `pairs`: parent_from_child (4, 4) of the file and of the robot, first at
    the start, then at spread values."""
    names, tolerance = read_robot.attribute_names, read_robot.precision.pose
    (rest, expected_rest), *spread = pairs
    errors = [
        offset_and_angle(inverse(rest) @ pose, inverse(expected_rest) @ expected_pose)
        for pose, expected_pose in spread
    ]
    scalars = [dof for dof in joint.dofs if dof.kind in ("turn", "slide")]
    if joint.dofs and largest_error(value for pair in errors for value in pair) > tolerance:
        dof = next((scalar for scalar in scalars if not _same_axis(read_robot, joint, scalar)), joint.dofs[0])
        element, axis = read_robot.element("joint", dof.name), read_robot.axis(dof)
        turns_wrongly = largest_error(angle for _, angle in errors) > tolerance
        if axis is None:
            attributes = f"{names.place[0]}, {names.axis}"
            yield Finding(element, attributes, "moves its child differently than the robot's")
        elif dof.kind == "slide" or (dof.kind == "turn" and turns_wrongly):
            yield differs(element, names.axis, axis, dof.axis)
        elif turns_wrongly:
            yield Finding(element, names.place[1], "turns differently than the robot's")
        else:
            yield Finding(element, names.place[0], "is not where the robot's axis is")
        return
    for dof in scalars:
        start_values = read_robot.zero(dof)
        if start_values is None:
            continue
        actual_start, expected_start = start_values
        if not abs(actual_start - expected_start) <= ENGINE_TOLERANCE * max(1.0, abs(expected_start)):
            yield differs(read_robot.element("joint", dof.name), names.zero, actual_start, expected_start)
            return
    yield from pose_findings(read_robot.placing_element(joint), rest, expected_rest, names.place, tolerance)


def _same_axis(read_robot: ReadRobot, joint: Joint, dof: Dof) -> bool:
    """Tells whether the file's axis is that of the dof. Only a child's last joint is surely in the axes of
    the child."""
    axis = read_robot.axis(dof)
    return len(joint.dofs) > 1 or axis is None or float(np.abs(axis - dof.axis).max()) <= ENGINE_TOLERANCE


def _frame_findings(read_robot: ReadRobot, poses: Poses) -> Iterator[Finding]:
    for frame in read_robot.robot.frames:
        if frame.name not in poses.frames:
            continue
        pose = inverse(poses.links[frame.link]) @ poses.frames[frame.name]
        element = read_robot.element("frame", frame.name)
        if np.isnan(pose).any():
            yield Finding(element, "name", "is missing")
        elif not distance(pose, frame.link_from_frame) <= ENGINE_TOLERANCE:
            yield from pose_findings(
                element, pose, frame.link_from_frame, read_robot.attribute_names.place, ENGINE_TOLERANCE
            )
