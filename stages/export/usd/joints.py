"""Converts joints and loops to joints of UsdPhysics: their types, and their frames on both bodies.

A joint of several degrees of freedom becomes a chain of joints with links of almost no mass between them,
since the articulations of PhysX have no other. A loop becomes a single joint outside the articulation,
whatever its type, so that no massless link is part of it. With several degrees of freedom it is a general
joint whose other axes are locked.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from linkwright.stages.formats.usd.names import UsdNames
from linkwright.stages.robot.model.poses import at_rest, from_parts, motion, rotation_from_quat
from linkwright.stages.robot.model.robot import (
    Array,
    Configuration,
    Dof,
    Joint,
    Limits,
    Loop,
    Robot,
)

JointType = Literal["Fixed", "Revolute", "Prismatic", "Spherical", ""]
"""A joint type of UsdPhysics, in `Physics<type>Joint`; "" is the general joint."""

_TYPES: Mapping[str, JointType] = {"turn": "Revolute", "slide": "Prismatic", "ball": "Spherical"}

AXES = "XYZ"
"""The letters of a frame's axes in UsdPhysics."""

_X_IS_Z = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""A rotation (3, 3) that makes x the former z axis."""

_AXIS_TOLERANCE = 1e-12
"""Largest difference of an axis from a coordinate axis that counts as the same axis."""


@dataclass(frozen=True, slots=True, eq=False)
class FreeAxis:
    """A degree of freedom of a general joint: along (`trans`) or about (`rot`) an axis of its frame."""

    kind: Literal["trans", "rot"]
    axis: str
    limits: Limits


@dataclass(frozen=True, slots=True, eq=False)
class UsdJoint:
    """A joint of the USD. Links and joints have the names of their prims."""

    name: str
    type: JointType

    first: str
    """The first body."""

    second: str
    """The second body."""

    first_from_joint: Array
    """The joint's frame (4, 4) on the first body."""

    second_from_joint: Array
    """The joint's frame (4, 4) on the second body."""

    axis: str = "X"
    """The axis of the joint's frame that it turns about or slides along."""

    dof: Dof | None = None
    """The robot's dof; None for a fixed or general joint."""

    free_axes: tuple[FreeAxis, ...] = ()
    """The degrees of freedom of a general joint."""

    closes: bool = False
    """Whether the joint closes a loop."""

    @property
    def limits(self) -> Limits:
        """Returns the limits of the dof; no limits without a dof."""
        return Limits() if self.dof is None else self.dof.limits


def usd_joints(robot: Robot, names: UsdNames, zeros: Configuration) -> tuple[UsdJoint, ...]:
    """Returns the joints of the robot and then of its loops, in their order. A free joint needs no joint of
    the USD. `zeros`: the values of balls at which their joints are at zero."""
    joints: list[UsdJoint] = []
    for joint in robot.joints:
        if joint.type != "free":
            links = (names.links[joint.parent], *names.links_between[joint.name], names.links[joint.child])
            joints += _chain(joint, links, joint.parent_from_joint, np.eye(4), names, zeros)
    for loop in robot.loops:
        links = (names.links[loop.link_b], *names.links_between[loop.name], names.links[loop.link_a])
        general_joint = _general_joint(loop, links, names)
        *inner, last = (
            [general_joint]
            if general_joint is not None
            else _chain(loop, links, loop.b_from_frame, loop.a_from_frame, names, {})
        )
        joints += [*inner, replace(last, closes=True)]
    return tuple(joints)


def added_links(robot: Robot, names: UsdNames, joints: tuple[UsdJoint, ...]) -> tuple[tuple[str, str], ...]:
    """Returns the links between those of the robot, each with the name of the joint or loop that it belongs
    to."""
    # A loop that is a single joint does not use the links between its dofs.
    used = {joint.first for joint in joints}
    chains: list[Joint | Loop] = [*robot.joints, *robot.loops]
    return tuple(
        (name, joint.name) for joint in chains for name in names.links_between[joint.name] if name in used
    )


def _chain(
    joint: Joint | Loop,
    links: tuple[str, ...],
    first_from_chain: Array,
    last_from_chain: Array,
    names: UsdNames,
    zeros: Configuration,
) -> Iterator[UsdJoint]:
    """Yields the joints from the first link to the last. `first_from_chain`: the frame (4, 4) on the first
    link in which the first dof begins; `last_from_chain`: the frame (4, 4) on the last link in which the last
    dof ends."""
    if not joint.dofs:
        yield UsdJoint(
            names.joints[joint.name], "Fixed", links[0], links[-1], first_from_chain, last_from_chain
        )
    for index, dof in enumerate(joint.dofs):
        axis, dof_from_joint = _aligned_frame(dof)
        is_first, is_last = index == 0, index == len(joint.dofs) - 1
        yield UsdJoint(
            names.joints[dof.name],
            _TYPES[dof.kind],
            links[index],
            links[index + 1],
            (first_from_chain if is_first else np.eye(4))
            @ dof.origin
            @ motion(dof.kind, dof.axis, zeros.get(dof.name, at_rest(dof.kind)))
            @ dof_from_joint,
            (last_from_chain if is_last else np.eye(4)) @ dof_from_joint,
            axis,
            dof,
        )


def _aligned_frame(dof: Dof) -> tuple[str, Array]:
    """Returns the letter of an axis, and dof_from_joint (4, 4): a frame of the joint in which this axis is
    the dof's own."""
    if dof.kind == "ball":
        # The cone is about z, and PhysX accepts only the axis X.
        return "X", from_parts(_X_IS_Z, np.zeros(3))
    for index, letter in enumerate(AXES):
        unit = np.eye(3)[index]
        if np.abs(dof.axis - unit).max() < _AXIS_TOLERANCE:
            return letter, np.eye(4)
        if np.abs(dof.axis + unit).max() < _AXIS_TOLERANCE:
            # Half a turn about another axis is exact.
            return letter, from_parts(np.diag(2 * np.eye(3)[(index + 1) % 3] - 1), np.zeros(3))
    x, y, z = dof.axis
    # The shortest rotation from x to the axis is about x × axis = (0, −z, y).
    rotation = rotation_from_quat(np.array([1 + x, 0.0, -z, y]))
    return "X", from_parts(rotation, np.zeros(3))


def _general_joint(loop: Loop, links: tuple[str, ...], names: UsdNames) -> UsdJoint | None:
    """Returns a loop of several dofs as a single joint; None unless its slides, and then its turn, are along
    the axes of a frame."""
    if len(loop.dofs) < 2:
        return None
    free_axes: list[FreeAxis] = []
    for index, dof in enumerate(loop.dofs):
        # At most one coordinate of a unit vector is 1 or -1.
        parallel_axes = [
            coordinate for coordinate in range(3) if abs(abs(dof.axis[coordinate]) - 1) < _AXIS_TOLERANCE
        ]
        has_turn = any(free_axis.kind == "rot" for free_axis in free_axes)
        is_moved = index > 0 and np.abs(dof.origin - np.eye(4)).max() > _AXIS_TOLERANCE
        if dof.kind == "ball" or not parallel_axes or has_turn or is_moved:
            return None
        limits = dof.limits.mapped(-1 if dof.axis[parallel_axes[0]] < 0 else 1)
        free_axes.append(FreeAxis("rot" if dof.kind == "turn" else "trans", AXES[parallel_axes[0]], limits))
    if len({(free_axis.kind, free_axis.axis) for free_axis in free_axes}) < len(free_axes):
        return None
    b_from_joint = loop.b_from_frame @ loop.dofs[0].origin
    return UsdJoint(
        names.joints[loop.name],
        "",
        links[0],
        links[-1],
        b_from_joint,
        loop.a_from_frame,
        free_axes=tuple(free_axes),
    )
