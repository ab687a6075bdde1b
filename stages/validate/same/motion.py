"""Compares the places of links and frames: where CAD saved the parts, and where the joints move them.

The robot's own kinematics is the reference for motion: it was compared with CAD at the saved pose.
"""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate.findings import shown
from linkwright.stages.validate.model.coordinates import CAD_ERROR, distance, saved_values, spread_values
from linkwright.stages.validate.same.differences import PosePair, differences
from linkwright.stages.validate.same.read_robot import Poses, ReadRobot


def poses(read: ReadRobot) -> Iterator[Check]:
    """Checks that every part is where CAD's occurrence has it, at the saved configuration.

    Poses are relative to the root, which a file may put anywhere. Links on free joints that the file does not
    have may be anywhere.
    """
    robot = read.robot
    links = read.poses({**saved_values(robot), **read.fixed_dofs}).links
    root_from_cad, worst, worst_part, holder = inverse(robot.world_from_root), 0.0, "", ""
    held_links = _held_links(read)
    for link in robot.links:
        for part in link.parts if link.name in held_links else ():
            value = distance(links[link.name] @ part.link_from_part, root_from_cad @ part.world_from_part)
            if not value < worst:
                worst, worst_part, holder = value, part.name, link.name
    detail = f"parts against CAD's occurrences at the saved pose [m, rad]; worst: {worst_part}"
    limit = max(CAD_ERROR, read.precision.pose * (_size(links) if read.precision.scales_with_size else 1.0))
    findings: tuple[Finding, ...] = ()
    if not worst <= limit:
        message = f"its part {worst_part} is {shown(worst)} m or rad from CAD's occurrence"
        element = read.element("link", holder)
        findings = kinematic_differences(read) or (Finding(element, read.attribute_names.place[0], message),)
    yield read.within("poses", worst, limit, detail, findings)


def motion(read: ReadRobot) -> Iterator[Check]:
    """Compares links and frames at spread values of the dofs."""
    worst, worst_name, pairs = 0.0, "", pose_pairs(read)
    for pair in pairs:
        for name, value in _pose_errors(read, pair):
            value = math.inf if math.isnan(value) else value
            if value > worst:
                worst, worst_name = value, name
    detail = "links and frames at four configurations against the robot's own kinematics [m, rad]; worst: "
    limit, findings = read.precision.pose, tuple[Finding, ...]()
    if not worst <= limit:
        element = read.element("frame" if worst_name in pairs[0].actual.frames else "link", worst_name)
        message = f"is {shown(worst)} m or rad from where the robot has it"
        findings = differences(read, pairs) or (Finding(element, read.attribute_names.place[0], message),)
    yield read.within("motion", worst, limit, detail + worst_name, findings)


def kinematic_differences(read: ReadRobot) -> tuple[Finding, ...]:
    """Returns findings on the causes of links or frames that are not at the robot's places."""
    return differences(read, pose_pairs(read))


def pose_pairs(read: ReadRobot) -> list[PosePair]:
    """Returns the poses of the file and of the robot: first at the file's own placement or at zero, then at
    spread values."""
    robot, pairs = read.robot, []
    for q in (
        read.file_configuration,
        *({**spread_values(robot, turn), **read.fixed_dofs} for turn in range(3)),
    ):
        links = link_poses(robot, q)
        frames = {frame.name: links[frame.link] @ frame.link_from_frame for frame in robot.frames}
        pairs.append(PosePair(read.poses(q), Poses(links, frames)))
    return pairs


def _pose_errors(read: ReadRobot, pair: PosePair) -> Iterator[tuple[str, float]]:
    size = _size(pair.expected.links) if read.precision.scales_with_size else 1.0
    for actual, expected in (
        (pair.actual.links, pair.expected.links),
        (pair.actual.frames, pair.expected.frames),
    ):
        yield from (
            (name, distance(actual[name], pose) / size) for name, pose in expected.items() if name in actual
        )


def _size(links: Mapping[str, Array]) -> float:
    """Returns the robot's reach [m] from its root, at least 1."""
    return max(1.0, *(float(np.abs(pose[:3, 3]).max()) for pose in links.values()))


def _held_links(read: ReadRobot) -> set[str]:
    """Returns the links that the joints of the file connect to the root."""
    held_links = {read.robot.root.name}
    for joint in read.robot.joints:
        if joint.parent in held_links and not any(dof.name in read.fixed_dofs for dof in joint.dofs):
            held_links.add(joint.child)
    return held_links
