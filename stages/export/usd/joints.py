"""Joints and loops as joints of UsdPhysics: which type, and where their frames are on both bodies.

A joint of several degrees of freedom is a row of joints with links of next to no mass between them, since the
articulations of PhysX have no other. A loop is one joint outside the articulation, whatever its type, so that
nothing without mass is in it: several degrees of freedom are a joint whose others are locked.
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
    Dynamics,
    Joint,
    Limits,
    Loop,
    Robot,
)

JointType = Literal["Fixed", "Revolute", "Prismatic", "Spherical", ""]
"""Of UsdPhysics: `Physics<type>Joint`; "" is the general one."""

_TYPES: Mapping[str, JointType] = {"turn": "Revolute", "slide": "Prismatic", "ball": "Spherical"}

AXES = "XYZ"

_X_IS_Z = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""The rotation (3, 3) whose x axis is z."""

_SAME = 1e-12
"""An axis that is off a coordinate axis by less is that one."""


@dataclass(frozen=True, slots=True, eq=False)
class Free:
    """A degree of freedom of a general joint: along (`trans`) or about (`rot`) an axis of its frame."""

    kind: Literal["trans", "rot"]
    axis: str
    limits: Limits


@dataclass(frozen=True, slots=True, eq=False)
class UsdJoint:
    """One joint; links and joints by the names of their prims.

    `first_from_joint`, `second_from_joint` (4, 4): its frame on either body, `first` None for the robot's
    own. `axis`: that of the frame that it turns about or slides along. `dof`: the robot's, None for a fixed
    joint. `free`: of a general joint. `closes`: whether it is a loop's.
    """

    name: str
    type: JointType
    first: str | None
    second: str
    first_from_joint: Array
    second_from_joint: Array
    axis: str = "X"
    dof: Dof | None = None
    free: tuple[Free, ...] = ()
    closes: bool = False

    @property
    def limits(self) -> Limits:
        return Limits() if self.dof is None else self.dof.limits

    @property
    def dynamics(self) -> Dynamics:
        return Dynamics() if self.dof is None else self.dof.dynamics


def usd_joints(robot: Robot, names: UsdNames, zeros: Configuration) -> tuple[UsdJoint, ...]:
    """The joints of the robot and then of its loops, in their order. Free motion needs none. `zeros`: of
    balls whose joints turn on from a value."""
    found: list[UsdJoint] = []
    for joint in robot.joints:
        if joint.type != "free":
            links = (names.links[joint.parent], *names.between[joint.name], names.links[joint.child])
            found += _row(joint, links, joint.parent_from_joint, np.eye(4), names, zeros)
    for loop in robot.loops:
        links = (names.links[loop.link_b], *names.between[loop.name], names.links[loop.link_a])
        one = _general(loop, links, names)
        *before, last = [one] if one else _row(loop, links, loop.b_from_frame, loop.a_from_frame, names, {})
        found += [*before, replace(last, closes=True)]
    return tuple(found)


def added_links(robot: Robot, names: UsdNames, joints: tuple[UsdJoint, ...]) -> tuple[tuple[str, str], ...]:
    """The links between those of the robot, each with the name of the joint or loop that it is for."""
    used = {joint.first for joint in joints}
    chains: list[Joint | Loop] = [*robot.joints, *robot.loops]
    return tuple((name, one.name) for one in chains for name in names.between[one.name] if name in used)


def _row(
    one: Joint | Loop,
    links: tuple[str, ...],
    before: Array,
    after: Array,
    names: UsdNames,
    zeros: Configuration,
) -> Iterator[UsdJoint]:
    """The joints from the first link to the last: the first is at `before` in its link, the last at
    `after`."""
    if not one.dofs:
        yield UsdJoint(names.joints[one.name], "Fixed", links[0], links[-1], before, after)
    for index, dof in enumerate(one.dofs):
        axis, turned = _aligned(dof)
        last = index == len(one.dofs) - 1
        yield UsdJoint(
            names.joints[dof.name],
            _TYPES[dof.kind],
            links[index],
            links[index + 1],
            before @ dof.origin @ motion(dof.kind, dof.axis, zeros.get(dof.name, at_rest(dof.kind))) @ turned,
            (after if last else np.eye(4)) @ turned,
            axis,
            dof,
        )
        before = np.eye(4)


def _aligned(dof: Dof) -> tuple[str, Array]:
    """An axis of the joint's frame, and dof_from_joint (4, 4), which takes that axis to the dof's own."""
    if dof.kind == "ball":
        # The cone is about z, and PhysX takes no other axis than X.
        return "X", from_parts(_X_IS_Z, np.zeros(3))
    for index, token in enumerate(AXES):
        unit = np.eye(3)[index]
        if np.abs(dof.axis - unit).max() < _SAME:
            return token, np.eye(4)
        if np.abs(dof.axis + unit).max() < _SAME:
            # Half a turn about another axis, which has no digits to lose.
            return token, from_parts(np.diag(2 * np.eye(3)[(index + 1) % 3] - 1), np.zeros(3))
    x, y, z = dof.axis
    # The shortest turn from x: that about x × axis = (0, −z, y).
    turned = rotation_from_quat(np.array([1 + x, 0.0, -z, y]))
    return "X", from_parts(turned, np.zeros(3))


def _general(loop: Loop, links: tuple[str, ...], names: UsdNames) -> UsdJoint | None:
    """A loop of several dofs as one joint, where its slides and then its turn are along the axes of one
    frame; None where it is not so."""
    if len(loop.dofs) < 2:
        return None
    free: list[Free] = []
    for index, dof in enumerate(loop.dofs):
        own = [at for at in range(3) if abs(abs(dof.axis[at]) - 1) < _SAME]
        after_turn = any(one.kind == "rot" for one in free)
        moved = index > 0 and np.abs(dof.origin - np.eye(4)).max() > _SAME
        if dof.kind == "ball" or not own or after_turn or moved:
            return None
        limits = dof.limits.mapped(-1 if dof.axis[own[0]] < 0 else 1)
        free.append(Free("rot" if dof.kind == "turn" else "trans", AXES[own[0]], limits))
    if len({(one.kind, one.axis) for one in free}) < len(free):
        return None
    place = loop.b_from_frame @ loop.dofs[0].origin
    return UsdJoint(
        names.joints[loop.name], "", links[0], links[-1], place, loop.a_from_frame, free=tuple(free)
    )
