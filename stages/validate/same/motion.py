"""Compares the places of links and frames: where CAD saved the parts, and where the joints move them.

The robot's own kinematics is the reference for motion: it was compared with CAD at the saved pose.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate.findings import shown
from linkwright.stages.validate.model.coordinates import CAD_ERROR, distance, saved_values, spread_values
from linkwright.stages.validate.same.differences import PosePair, differences
from linkwright.stages.validate.same.read_robot import ElementKind, Poses, ReadRobot


def compare_with_cad(read_robot: ReadRobot) -> Iterator[Check]:
    """Checks that every part is where CAD's occurrence has it, at the saved values of the dofs.

    Poses are relative to the root, which a file may put anywhere. Links that the joints of the file do not
    connect to the root are not compared, since they may be anywhere.
    """
    robot, precision = read_robot.robot, read_robot.precision
    q = {**saved_values(robot), **read_robot.fixed_dofs}
    root_from_link = read_robot.poses(q).links
    root_from_cad = inverse(robot.world_from_root)
    connected_links = _connected_links(read_robot)
    worst_error, worst_part, worst_link = 0.0, "", ""
    for link in robot.links:
        if link.name not in connected_links:
            continue
        for part in link.parts:
            root_from_part = root_from_link[link.name] @ part.link_from_part
            error = distance(root_from_part, root_from_cad @ part.world_from_part)
            if error >= worst_error:
                worst_error, worst_part, worst_link = error, part.name, link.name
    detail = f"parts against CAD's occurrences at the saved pose [m, rad]; worst: {worst_part}"
    limit = max(CAD_ERROR, precision.pose * _pose_scale(read_robot, link_poses(robot, q)))
    findings: tuple[Finding, ...] = ()
    if worst_error > limit:
        message = f"its part {worst_part} is {shown(worst_error)} m or rad from CAD's occurrence"
        element = read_robot.element("link", worst_link)
        findings = kinematic_differences(read_robot) or (
            Finding(element, read_robot.attribute_names.place[0], message),
        )
    yield read_robot.within("poses", worst_error, limit, detail, findings)


def compare_motion(read_robot: ReadRobot) -> Iterator[Check]:
    """Compares links and frames with the robot's own kinematics, at several values of the dofs."""
    worst_error, worst_distance, worst_name, pairs = 0.0, 0.0, "", pose_pairs(read_robot)
    for pair in pairs:
        scale = _pose_scale(read_robot, pair.expected.links)
        for name, pose_distance in _pose_distances(pair):
            # If the precision of the format scales with the robot's size, so do the errors.
            error = pose_distance / scale
            if error > worst_error:
                worst_error, worst_distance, worst_name = error, pose_distance, name
    detail = "links and frames at four configurations against the robot's own kinematics [m, rad]; worst: "
    limit, findings = read_robot.precision.pose, tuple[Finding, ...]()
    if worst_error > limit:
        kind: ElementKind = "frame" if worst_name in pairs[0].actual.frames else "link"
        message = f"is {shown(worst_distance)} m or rad from where the robot has it"
        findings = differences(read_robot, pairs) or (
            Finding(read_robot.element(kind, worst_name), read_robot.attribute_names.place[0], message),
        )
    yield read_robot.within("motion", worst_error, limit, detail + worst_name, findings)


def kinematic_differences(read_robot: ReadRobot) -> tuple[Finding, ...]:
    """Returns findings on the joints, links and frames that misplace links or frames, see `differences`."""
    return differences(read_robot, pose_pairs(read_robot))


def pose_pairs(read_robot: ReadRobot) -> list[PosePair]:
    """Returns the poses of the file and of the robot at four configurations: first at
    `file_configuration`, then at three with spread values."""
    robot, pairs = read_robot.robot, []
    spread_configurations = (
        {**spread_values(robot, sample_index), **read_robot.fixed_dofs} for sample_index in range(3)
    )
    for q in (read_robot.file_configuration, *spread_configurations):
        links = link_poses(robot, q)
        frames = {frame.name: links[frame.link] @ frame.link_from_frame for frame in robot.frames}
        pairs.append(PosePair(read_robot.poses(q), Poses(links, frames)))
    return pairs


def _pose_distances(pair: PosePair) -> Iterator[tuple[str, float]]:
    """Yields the distance [m, rad] of each link and frame that the file has from where the robot has it, by
    name."""
    for actual, expected in (
        (pair.actual.links, pair.expected.links),
        (pair.actual.frames, pair.expected.frames),
    ):
        for name, pose in expected.items():
            if name in actual:
                yield name, distance(actual[name], pose)


def _pose_scale(read_robot: ReadRobot, links: Mapping[str, Array]) -> float:
    """Returns the factor of the format's tolerance of poses: the reach [m] of the links from the root, at
    least 1, if the tolerance scales with it; else 1. `links`: root_from_link (4, 4) by name."""
    if not read_robot.precision.scales_with_size:
        return 1.0
    return max(1.0, *(float(np.abs(root_from_link[:3, 3]).max()) for root_from_link in links.values()))


def _connected_links(read_robot: ReadRobot) -> set[str]:
    """Returns the links that the joints of the file connect to the root."""
    connected_links = {read_robot.robot.root.name}
    # Parents come before their children.
    for joint in read_robot.robot.joints:
        is_in_file = not any(dof.name in read_robot.fixed_dofs for dof in joint.dofs)
        if joint.parent in connected_links and is_in_file:
            connected_links.add(joint.child)
    return connected_links
