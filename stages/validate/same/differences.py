"""Where a file's kinematics leaves the robot's: the first elements of the tree that are not as they must be.

Each link is looked at from its parent alone, so that what is wrong above it does not count for it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Dof, Joint
from linkwright.stages.validate.findings import apart, differs, few, place_differs
from linkwright.stages.validate.model.coordinates import SAME, distance
from linkwright.stages.validate.same.found import Poses, ReadRobot


@dataclass(frozen=True, slots=True, eq=False)
class PosePair:
    """Poses at the same values: those of the file, and those of the robot."""

    found: Poses
    expected: Poses


def differences(read: ReadRobot, looks: Sequence[PosePair]) -> tuple[Finding, ...]:
    """Findings on joints, links and frames whose pose on what carries them is not the robot's, parents
    first. `looks`: first where the file stands, or at zero, then at values spread over those of the dofs."""
    return few([*_joints(read, looks), *_frames(read, looks[0].found)])


def _joints(read: ReadRobot, looks: Sequence[PosePair]) -> Iterator[Finding]:
    for joint in read.robot.joints:
        pairs = [tuple(_on_parent(joint, poses) for poses in (look.found, look.expected)) for look in looks]
        if all(distance(*pair) <= read.precision.pose for pair in pairs):
            continue
        parent = read.parent(joint.child)
        if parent != joint.parent:
            yield differs(read.placed(joint), "parent", parent or "none of the robot's links", joint.parent)
        else:
            yield from _of_joint(read, joint, pairs)


def _on_parent(joint: Joint, poses: Poses) -> Array:
    return inverse(poses.links[joint.parent]) @ poses.links[joint.child]


def _of_joint(read: ReadRobot, joint: Joint, pairs: list[tuple[Array, ...]]) -> Iterator[Finding]:
    """What is wrong with a joint: its axis or place where the child moves otherwise than from where it
    stands, else where the child stands."""
    words, least = read.words, read.precision.pose
    (rest, wanted), *others = pairs
    off = [apart(inverse(rest) @ found, inverse(wanted) @ expected) for found, expected in others]
    scalars = [dof for dof in joint.dofs if dof.kind in ("turn", "slide")]
    if joint.dofs and not max(value for both in off for value in both) <= least:
        dof = next((one for one in scalars if not _same_axis(read, joint, one)), joint.dofs[0])
        element, axis = read.element("joint", dof.name), read.axis(dof)
        turned = not max(angle for _, angle in off) <= least
        if axis is None:
            attributes = f"{words.place[0]}, {words.axis}"
            yield Finding(element, attributes, "moves its child otherwise than the robot's")
        elif dof.kind == "slide" or (dof.kind == "turn" and turned):
            yield differs(element, words.axis, axis, dof.axis)
        elif turned:
            yield Finding(element, words.place[1], "turns otherwise than the robot's")
        else:
            yield Finding(element, words.place[0], "is not where the robot's axis is")
        return
    for dof in scalars:
        zero = read.zero(dof)
        if zero is not None and not abs(zero[0] - zero[1]) <= SAME * max(1.0, abs(zero[1])):
            yield differs(read.element("joint", dof.name), words.zero, *zero)
            return
    yield from place_differs(read.placed(joint), rest, wanted, words.place, least)


def _same_axis(read: ReadRobot, joint: Joint, dof: Dof) -> bool:
    """Whether the file's axis is that of the dof: of the joints of one child only the last is sure to be in
    the axes of that, and so is the only one."""
    axis = read.axis(dof)
    return len(joint.dofs) > 1 or axis is None or float(np.abs(axis - dof.axis).max()) <= SAME


def _frames(read: ReadRobot, found: Poses) -> Iterator[Finding]:
    for frame in read.robot.frames:
        if frame.name not in found.frames:
            continue
        own = inverse(found.links[frame.link]) @ found.frames[frame.name]
        element = read.element("frame", frame.name)
        if np.isnan(own).any():
            yield Finding(element, "name", "there is none of this name")
        elif not distance(own, frame.link_from_frame) <= SAME:
            yield from place_differs(element, own, frame.link_from_frame, read.words.place, SAME)
