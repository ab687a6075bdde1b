"""The robot's own kinematics: poses of its links at any configuration."""

from collections.abc import Mapping

import numpy as np

from stages.robot.model import Array, Robot
from stages.robot.poses import motion


def link_poses(robot: Robot, q: Mapping[str, float] | None = None) -> dict[str, Array]:
    """root_from_link (4, 4) of every link at joint values `q` [rad or m]; a missing value is 0."""
    q = q or {}
    poses: dict[str, Array] = {robot.root.name: np.eye(4)}
    for joint in robot.joints:
        step = motion(joint.type, joint.axis, q.get(joint.name, 0.0))
        poses[joint.child] = poses[joint.parent] @ joint.parent_from_joint @ step
    return poses


def saved_configuration(robot: Robot) -> dict[str, float]:
    """Joint values of the pose that CAD was left in."""
    return {joint.name: joint.saved for joint in robot.joints}
