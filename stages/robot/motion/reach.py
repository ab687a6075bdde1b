"""Measures the reach of a robot's frames from its base."""

import numpy as np

from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.pose_batch import many_link_poses, repeated
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home

POSES = 256
"""Number of poses at which the reach is measured, beside `home`."""

_SLIDE_REACH = 0.5
"""Motion [m] to both sides of a slide without limits."""

_DIGITS = 9
"""Number of decimals in which all machines agree."""


def reaches(robot: Robot) -> dict[str, float]:
    """Returns the largest distance [m] of each frame from the origin of the root link, at `home` and at the
    sampled poses within the limits. If the robot has no frames, the distances are those of its links'
    origins."""
    start = home(robot)
    link_poses = many_link_poses(robot, sampled_poses(robot, POSES, _SLIDE_REACH, start))
    home_link_poses = many_link_poses(robot, repeated(start, 1))
    points = {link.name: (link.name, np.zeros(3)) for link in robot.links}
    if robot.frames:
        points = {frame.name: (frame.link, frame.link_from_frame[:3, 3]) for frame in robot.frames}
    distances = {}
    for name, (link, point) in points.items():
        poses = np.concatenate([home_link_poses[link], link_poses[link]])
        positions = poses[:, :3, :3] @ point + poses[:, :3, 3]
        distances[name] = round(float(np.linalg.norm(positions, axis=1).max()), _DIGITS)
    return distances
