"""What closes a loop is where the robot has it, at values at which nothing is closed."""

from collections.abc import Iterator

import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.findings import place_differs, worst_first
from linkwright.stages.validate.model.coordinates import distance, spread
from linkwright.stages.validate.same.found import FoundPlace, ReadRobot


def loops(read: ReadRobot, name: str = "loops") -> Iterator[Check]:
    """One result, of a robot with loops. `name`: of the check."""
    worst, where, off = 0.0, "", dict[tuple[str, str], tuple[float, Finding]]()
    for turn in range(2):
        q = {**spread(read.robot, turn), **read.still}
        for loop in read.robot.loops:
            for place in read.places(loop, q):
                value = np.inf if place.found is None else distance(place.found, place.expected)
                value = np.inf if np.isnan(value) else value
                if not value < worst:
                    worst, where = value, loop.name
                for finding in _findings(place, loop.name, read.precision.pose):
                    off.setdefault((finding.element, finding.attribute), (value, finding))
    if read.robot.loops:
        detail = f"what closes each loop against the robot's own kinematics [m, rad]; worst: {where}"
        yield read.within(name, worst, read.precision.pose, detail, worst_first(off.values()))


def _findings(place: FoundPlace, loop: str, least: float) -> tuple[Finding, ...]:
    if place.found is None:
        message = f"does not close the loop {loop} as the robot has it"
        return (Finding(place.element, place.attributes[0], message),)
    return place_differs(place.element, place.found, place.expected, place.attributes, least)
