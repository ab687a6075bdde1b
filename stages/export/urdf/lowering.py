"""Converts joints of several degrees of freedom to chains of URDF joints and almost massless links."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from linkwright.stages.formats.urdf.names import UrdfNames, urdf_names
from linkwright.stages.robot.model.robot import Array, Dof, Dynamics, Joint, Limits, Robot

UrdfJointType = Literal["fixed", "continuous", "revolute", "prismatic", "floating"]


@dataclass(frozen=True, slots=True, eq=False)
class LoweredJoint:
    """A joint of the URDF."""

    name: str
    type: UrdfJointType
    parent: str
    child: str

    parent_from_joint: Array
    """Its origin (4, 4)."""

    axis: Array | None
    """(3,); None for a joint without an axis."""

    limits: Limits
    dynamics: Dynamics


@dataclass(frozen=True, slots=True, eq=False)
class JointChain:
    """A joint of the robot, and the URDF joints that it becomes."""

    joint: Joint
    joints: tuple[LoweredJoint, ...]
    """The URDF joints, from parent to child."""

    @property
    def added_links(self) -> tuple[str, ...]:
        """Returns the links added between the URDF joints."""
        return tuple(joint.child for joint in self.joints[:-1])


@dataclass(frozen=True, slots=True, eq=False)
class _UnplacedJoint:
    """A URDF joint that has no parent and child yet. `origin` (4, 4): its pose in the frame of the URDF joint
    before it."""

    name: str
    type: UrdfJointType
    origin: Array
    axis: Array | None
    limits: Limits
    dynamics: Dynamics


def lower(robot: Robot, joints: Sequence[Joint] | None = None) -> tuple[JointChain, ...]:
    """Returns the URDF joints of each of `joints`, by default of all joints of the robot, in their order.

    A turn or a slide becomes a joint of its dof's name. A ball becomes three turns `<name>_x`, `_y`, `_z`,
    about x, then y, then z: R = Rx Ry Rz. Links between them are `<joint>_<n>`.
    """
    names = urdf_names(robot)
    return tuple(_joint_chain(joint, names) for joint in (robot.joints if joints is None else joints))


def unset_limits(dof: Dof) -> list[str]:
    """Returns the limits (lower, upper, effort, velocity) that URDF requires of a dof and that are not
    set."""
    if dof.kind == "free":
        return []
    missing: list[str] = []
    if dof.kind != "ball":
        missing = [side for side in ("lower", "upper") if getattr(dof.limits, side) is None]
    if dof.kind == "turn" and len(missing) == 2:
        missing = []  # a continuous joint needs no range
    return missing + [key for key in ("effort", "velocity") if getattr(dof.dynamics, key) is None]


def _joint_chain(joint: Joint, names: UrdfNames) -> JointChain:
    """Returns the URDF joints of a joint."""
    # The links that the URDF joints connect, one more than there are URDF joints.
    links = [joint.parent, *names.links_between[joint.name], joint.child]
    joints = []
    pose = joint.parent_from_joint
    for part, parent, child in zip(_unplaced_joints(joint, names), links, links[1:], strict=False):
        origin = pose @ part.origin
        joints.append(
            LoweredJoint(part.name, part.type, parent, child, origin, part.axis, part.limits, part.dynamics)
        )
        pose = np.eye(4)
    return JointChain(joint, tuple(joints))


def _unplaced_joints(joint: Joint, names: UrdfNames) -> Iterator[_UnplacedJoint]:
    """Yields the URDF joints of a joint, from parent to child."""
    if not joint.dofs:
        yield _UnplacedJoint(joint.name, "fixed", np.eye(4), None, Limits(), Dynamics())
    for dof in joint.dofs:
        if dof.kind == "ball":
            yield from _turns_of_ball(dof, names.turns[dof.name])
        else:
            axis = None if dof.kind == "free" else dof.axis
            yield _UnplacedJoint(dof.name, _joint_type(dof), dof.origin, axis, dof.limits, dof.dynamics)


def _turns_of_ball(dof: Dof, names: tuple[str, str, str]) -> Iterator[_UnplacedJoint]:
    """Yields a ball as turns about x, y and z, without its cone."""
    origin = dof.origin
    for name, axis in zip(names, np.eye(3), strict=True):
        yield _UnplacedJoint(name, "continuous", origin, axis, Limits(), dof.dynamics)
        origin = np.eye(4)


def _joint_type(dof: Dof) -> UrdfJointType:
    """Returns the type of the URDF joint of a dof that is not a ball."""
    if dof.kind == "free":
        return "floating"
    if dof.kind == "slide":
        return "prismatic"
    return "continuous" if dof.limits.lower is None and dof.limits.upper is None else "revolute"
