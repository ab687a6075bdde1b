"""Where a model starts: the joint values at which a fresh simulation has all its loops closed."""

import math
from collections.abc import Mapping

from stages.robot.kinematics import link_poses, saved_configuration
from stages.robot.model import Joint, Loop, Robot
from stages.robot.poses import inverse

CLOSED = 1e-6
"""A loop counts as closed when its frames meet within this [m, and rad of tilt]."""


def starting_point(robot: Robot) -> dict[str, float]:
    """qpos0: mate zero where every loop and relation holds there, else the saved pose."""
    zero = dict.fromkeys((joint.name for joint in robot.joints), 0.0)
    holds = all(abs(relation.offset) == 0.0 for relation in robot.relations)
    if holds and all(gap(robot, loop, zero) <= CLOSED for loop in robot.loops):
        return zero
    return saved_configuration(robot)


def gap(robot: Robot, loop: Loop, q: Mapping[str, float]) -> float:
    """How far a loop is from closed at `q`: the larger of offset [m] and tilt of the axes [rad]."""
    poses = link_poses(robot, q)
    first = poses[loop.link_a] @ loop.a_from_frame
    second = poses[loop.link_b] @ loop.b_from_frame
    relative = inverse(second) @ first
    offset = math.hypot(*relative[:3, 3])
    return max(offset, math.hypot(relative[0, 2], relative[1, 2]))


def home(robot: Robot) -> dict[str, float]:
    """The saved pose, clipped to the limits."""
    return {joint.name: _clipped(joint) for joint in robot.joints}


def _clipped(joint: Joint) -> float:
    low = -math.inf if joint.limits.lower is None else joint.limits.lower
    high = math.inf if joint.limits.upper is None else joint.limits.upper
    return min(max(joint.saved, low), high)
