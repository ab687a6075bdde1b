"""Compares the poses of an SRDF's groups with the robot's keyframes."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.poses import motion
from linkwright.stages.robot.model.robot import Configuration
from linkwright.stages.robot.motion.start_pose import HOME, keyframes
from linkwright.stages.validate.findings import differs, named, shown
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE, distance
from linkwright.stages.validate.srdf.read_srdf import ReadSrdf, title_of_state


def state_findings(read: ReadSrdf) -> Iterator[Finding]:
    """Checks that each of the robot's groups has `home` and the robot's other keyframes, with every joint of
    the group at the robot's value. Poses of other names must be within limits."""
    names = [HOME, *(keyframe.name for keyframe in read.robot.keyframes if keyframe.name != HOME)]
    poses = keyframes(read.robot)
    existing = {(node.get("name"), node.get("group")) for node in read.root.findall("group_state")}
    for group in read.groups:
        if group not in read.robot_groups or not read.moved_by(group):
            continue
        for name in names:
            if (name, group) not in existing:
                element = f"{named('group_state', name)} of {named('group', group)}"
                yield Finding(element, "name", "is missing")
    for node in read.root.findall("group_state"):
        if node.get("group") in read.groups:
            values = {joint.get("name", ""): _joint_value(joint) for joint in node.findall("joint")}
            yield from _joint_findings(read, node, values)
            pose = poses[node.get("name")] if node.get("name") in names else None
            if pose is None:
                yield from _values_beyond_limits(read, node, values)
            else:
                yield from _differences_from_pose(read, node, values, pose)


def _joint_findings(read: ReadSrdf, node: Element, values: Mapping[str, float]) -> Iterator[Finding]:
    """Yields the joints that a pose lacks, or must not have, and values that are not finite numbers."""
    moved_joints = read.moved_by(node.get("group", ""))
    for joint in sorted((moved_joints ^ values.keys()) & read.chains.joints.keys()):
        message = "has no value" if joint in moved_joints else "is not a moving joint of the group"
        yield Finding(title_of_state(node), f"joint {joint}", message)
    for joint, value in values.items():
        if not math.isfinite(value):
            yield Finding(title_of_state(node), f"joint {joint} value", "is not a number")


def _differences_from_pose(
    read: ReadSrdf, node: Element, values: Mapping[str, float], pose: Configuration
) -> Iterator[Finding]:
    """Yields the values that differ from a pose of the robot."""
    values_by_ball: dict[str, list[tuple[str, float]]] = {}
    for joint, value in values.items():
        step = read.chains.joints.get(joint)
        if step is None or step.dof is None or not step.moves or not math.isfinite(value):
            continue
        expected = pose[step.dof.name]
        if isinstance(expected, tuple):
            values_by_ball.setdefault(step.dof.name, []).append((joint, value))
        elif abs(value - expected) > ENGINE_TOLERANCE * max(1.0, abs(expected)):
            yield differs(title_of_state(node), f"joint {joint} value", value, expected)
    order = list(read.chains.joints)
    for name, ball_joints in values_by_ball.items():
        # A ball is three joints in a row, which turn about x, then y, then z. If one of them has no value,
        # `_joint_findings` reports it.
        ball_joints.sort(key=lambda joint_and_value: order.index(joint_and_value[0]))
        pose_of_ball = np.eye(4)
        for (_, angle), axis in zip(ball_joints, np.eye(3), strict=False):
            pose_of_ball = pose_of_ball @ motion("turn", axis, angle)
        difference = distance(pose_of_ball, motion("ball", np.zeros(3), pose[name]))
        if len(ball_joints) == 3 and difference > ENGINE_TOLERANCE:
            message = f"is turned by {shown(math.degrees(difference))} degrees from where the robot has it"
            yield Finding(title_of_state(node), f"joint {ball_joints[0][0]} value", message)


def _values_beyond_limits(read: ReadSrdf, node: Element, values: Mapping[str, float]) -> Iterator[Finding]:
    """Yields the values beyond limits in a pose that the user added."""
    for joint, value in values.items():
        step = read.chains.joints.get(joint)
        low, high = step.limits.interval if step is not None else (-math.inf, math.inf)
        if not low - ENGINE_TOLERANCE <= value <= high + ENGINE_TOLERANCE and math.isfinite(value):
            message = f"is {shown(value)}, expected {shown(low)} to {shown(high)}"
            yield Finding(title_of_state(node), f"joint {joint} value", message)


def _joint_value(node: Element) -> float:
    """Returns the value of a `<joint>`; NaN if it is missing or not a number."""
    try:
        return float(node.get("value", ""))
    except ValueError:
        return math.nan
