"""Compares the frames that close a loop with the robot's, at values at which no loop is closed."""

from collections.abc import Iterator

import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.findings import pose_findings, worst_first
from linkwright.stages.validate.model.coordinates import distance, spread_values
from linkwright.stages.validate.same.read_robot import FoundPose, ReadRobot


def compare_loops(read_robot: ReadRobot, name: str = "loops") -> Iterator[Check]:
    """Yields a single result for a robot with loops, else nothing. `name`: the name of the check."""
    worst_error, worst_loop, findings_by_place = 0.0, "", dict[tuple[str, str], tuple[float, Finding]]()
    for sample_index in range(2):
        q = {**spread_values(read_robot.robot, sample_index), **read_robot.fixed_dofs}
        for loop in read_robot.robot.loops:
            for found_pose in read_robot.loop_poses(loop, q):
                error = np.inf if found_pose.pose is None else distance(found_pose.pose, found_pose.expected)
                if not error < worst_error:
                    worst_error, worst_loop = error, loop.name
                for finding in _findings(found_pose, loop.name, read_robot.precision.pose):
                    findings_by_place.setdefault((finding.element, finding.attribute), (error, finding))
    if read_robot.robot.loops:
        detail = f"what closes each loop against the robot's own kinematics [m, rad]; worst: {worst_loop}"
        yield read_robot.within(
            name, worst_error, read_robot.precision.pose, detail, worst_first(findings_by_place.values())
        )


def _findings(found_pose: FoundPose, loop: str, tolerance: float) -> tuple[Finding, ...]:
    if found_pose.pose is None:
        message = f"does not close the loop {loop} as the robot has it"
        return (Finding(found_pose.element, found_pose.attributes[0], message),)
    return pose_findings(
        found_pose.element, found_pose.pose, found_pose.expected, found_pose.attributes, tolerance
    )
