"""Links and frames are where the robot has them: where CAD saved its parts, and wherever its joints move.

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
from linkwright.stages.validate.model.coordinates import CAD_ERROR, distance, every_saved, spread
from linkwright.stages.validate.same.differences import PosePair, differences
from linkwright.stages.validate.same.found import Poses, ReadRobot


def poses(read: ReadRobot) -> Iterator[Check]:
    """At the saved configuration every part is where CAD's occurrence has it, in the axes of the root, which
    a file may put anywhere. What moves freely may stand anywhere, where the file has no joint for it."""
    robot = read.robot
    found = read.poses({**every_saved(robot), **read.still}).links
    root_from_cad, worst, where, holder = inverse(robot.world_from_root), 0.0, "", ""
    held = _held(read)
    for link in robot.links:
        for part in link.parts if link.name in held else ():
            value = distance(found[link.name] @ part.link_from_part, root_from_cad @ part.world_from_part)
            if not value < worst:
                worst, where, holder = value, part.name, link.name
    detail = f"parts against CAD's occurrences at the saved pose [m, rad]; worst: {where}"
    limit = max(CAD_ERROR, read.precision.pose * (_size(found) if read.precision.sized else 1.0))
    findings: tuple[Finding, ...] = ()
    if not worst <= limit:
        message = f"its part {where} is {shown(worst)} m or rad from CAD's occurrence"
        element = read.element("link", holder)
        findings = found_differences(read) or (Finding(element, read.words.place[0], message),)
    yield read.within("poses", worst, limit, detail, findings)


def motion(read: ReadRobot) -> Iterator[Check]:
    """Links and frames at configurations spread over the dofs' values."""
    worst, where, every = 0.0, "", looks(read)
    for look in every:
        for name, value in _off(read, look):
            value = math.inf if math.isnan(value) else value
            if value > worst:
                worst, where = value, name
    detail = "links and frames at four configurations against the robot's own kinematics [m, rad]; worst: "
    limit, findings = read.precision.pose, tuple[Finding, ...]()
    if not worst <= limit:
        element = read.element("frame" if where in every[0].found.frames else "link", where)
        message = f"is {shown(worst)} m or rad from where the robot has it"
        findings = differences(read, every) or (Finding(element, read.words.place[0], message),)
    yield read.within("motion", worst, limit, detail + where, findings)


def found_differences(read: ReadRobot) -> tuple[Finding, ...]:
    """Why links or frames are not where the robot has them."""
    return differences(read, looks(read))


def looks(read: ReadRobot) -> list[PosePair]:
    """The poses of the file and those of the robot: first where the file stands, or at zero."""
    robot, found = read.robot, []
    for q in (read.standing, *({**spread(robot, turn), **read.still} for turn in range(3))):
        links = link_poses(robot, q)
        frames = {frame.name: links[frame.link] @ frame.link_from_frame for frame in robot.frames}
        found.append(PosePair(read.poses(q), Poses(links, frames)))
    return found


def _off(read: ReadRobot, look: PosePair) -> Iterator[tuple[str, float]]:
    size = _size(look.expected.links) if read.precision.sized else 1.0
    for own, wanted in ((look.found.links, look.expected.links), (look.found.frames, look.expected.frames)):
        yield from ((name, distance(own[name], pose) / size) for name, pose in wanted.items() if name in own)


def _size(links: Mapping[str, Array]) -> float:
    """How far [m] a robot reaches from its root, at least 1."""
    return max(1.0, *(float(np.abs(pose[:3, 3]).max()) for pose in links.values()))


def _held(read: ReadRobot) -> set[str]:
    """The links that the joints of the file hold."""
    held = {read.robot.root.name}
    for joint in read.robot.joints:
        if joint.parent in held and not any(dof.name in read.still for dof in joint.dofs):
            held.add(joint.child)
    return held
