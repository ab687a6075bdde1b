"""Compares the frames that close a loop with the robot's, at values at which no loop is closed."""

from collections.abc import Iterator

import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.findings import pose_findings, worst_first
from linkwright.stages.validate.model.coordinates import distance, spread_values
from linkwright.stages.validate.same.read_robot import FoundPose, ReadRobot


def compare_loops(read: ReadRobot, name: str = "loops") -> Iterator[Check]:
    """Yields a single result for a robot with loops. `name`: the name of the check."""
    worst, worst_loop, findings_by_place = 0.0, "", dict[tuple[str, str], tuple[float, Finding]]()
    for sample_index in range(2):
        q = {**spread_values(read.robot, sample_index), **read.fixed_dofs}
        for loop in read.robot.loops:
            for place in read.loop_poses(loop, q):
                value = np.inf if place.pose is None else distance(place.pose, place.expected)
                if not value < worst:
                    worst, worst_loop = value, loop.name
                for finding in _findings(place, loop.name, read.precision.pose):
                    findings_by_place.setdefault((finding.element, finding.attribute), (value, finding))
    if read.robot.loops:
        detail = f"what closes each loop against the robot's own kinematics [m, rad]; worst: {worst_loop}"
        yield read.within(name, worst, read.precision.pose, detail, worst_first(findings_by_place.values()))


def _findings(place: FoundPose, loop: str, least: float) -> tuple[Finding, ...]:
    if place.pose is None:
        message = f"does not close the loop {loop} as the robot has it"
        return (Finding(place.element, place.attributes[0], message),)
    return pose_findings(place.element, place.pose, place.expected, place.attributes, least)
