"""Converts joints and loops of several degrees of freedom to chains of SDF joints and almost massless links,
and chooses the pose in which the links of the SDF stand."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from linkwright.stages.formats.sdf.names import SdfNames
from linkwright.stages.robot.model.poses import at_rest, inverse, motion
from linkwright.stages.robot.model.robot import (
    Array,
    Configuration,
    Dof,
    Dynamics,
    Joint,
    Limits,
    Loop,
    Relation,
    Robot,
    Value,
)
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loops import MAX_CLOSED_GAP, closing_values, gap, relative_pose
from linkwright.stages.robot.motion.tree_paths import TreePaths

SdfJointType = Literal["fixed", "continuous", "revolute", "prismatic", "ball"]

ZERO_TOLERANCE = 1e-12
"""Largest value [m or rad] that counts as zero: a loop that is closed at zero is closed only up to rounding
errors."""


@dataclass(frozen=True, slots=True)
class Mimic:
    """The relation of a follower: its value = multiplier · (value of `joint`) + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True, eq=False)
class SdfJoint:
    """A joint of the SDF. Links and joints have their names in the SDF."""

    name: str
    type: SdfJointType
    parent: str
    child: str

    pose_link: str
    """The link in whose frame the pose is: the parent, or the child for a joint that closes a loop."""

    link_from_joint: Array
    """The joint's pose (4, 4) in the frame of `pose_link`."""

    axis: Array | None
    """(3,); None for a joint without an axis."""

    limits: Limits
    """The limits, counted from the pose in which the links stand."""

    dynamics: Dynamics
    follows: Mimic | None

    carries_child: bool
    """Whether the child has the joint's frame. False for a joint that closes a loop: another joint carries
    its child."""


@dataclass(frozen=True, slots=True, eq=False)
class SdfJoints:
    """The joints of an SDF, and the pose in which its links stand."""

    joints: tuple[SdfJoint, ...]
    """The joints, in the order of the robot's joints and then of its loops."""

    floating: Mapping[str, tuple[str, Array]]
    """Link that no joint holds → the link in whose frame it stands, and its pose (4, 4) there."""

    added_links: tuple[str, ...]
    """The links that were added between those of the robot."""

    stance: Configuration
    """The value of each dof, including those of loops, in the pose in which the links stand. In this pose
    every SDF joint is at zero."""

    @property
    def nonzero_values(self) -> dict[str, Value]:
        """Returns the dofs that are not at zero in the pose in which the links stand, with their values."""
        return {name: value for name, value in self.stance.items() if _is_moved(value)}


def lower(robot: Robot, start: Configuration, names: SdfNames) -> SdfJoints:
    """Returns the SDF joints of each joint and loop. `start`: a value for each dof, including those of loops,
    at which the loops are closed.

    A turn or a slide becomes a joint of its dof's name, a ball becomes a ball. An SDF joint is at zero where
    its links stand, so the links stand where the loops are closed: at zero if they are closed there, else at
    `start`.
    """
    stance = _stance(robot, start)
    exchanged = {
        loop.name: _with_exchanged_links(loop) for loop in robot.loops if loop.link_a == robot.root.name
    }
    values = stance | _conjugated_values(exchanged.values(), stance)
    maker = _JointMaker(names, values, {relation.follower: relation for relation in robot.relations})
    joints: list[SdfJoint] = []
    floating: dict[str, tuple[str, Array]] = {}
    for joint in robot.joints:
        parent, child = names.links[joint.parent], names.links[joint.child]
        if joint.type == "free":
            (dof,) = joint.dofs
            child_pose = dof.origin @ motion(dof.kind, dof.axis, stance[dof.name])
            floating[child] = (parent, joint.parent_from_joint @ child_pose)
        else:
            joints += maker.joints_of(joint, parent, child, joint.parent_from_joint)
    for loop in (exchanged.get(original.name, original) for original in robot.loops):
        # From the second link to the first, which the tree already places.
        first = names.links[loop.link_a]
        *inner, last = maker.joints_of(loop, names.links[loop.link_b], first, loop.b_from_frame)
        joints += [
            *inner,
            replace(last, pose_link=first, link_from_joint=loop.a_from_frame, carries_child=False),
        ]
    added_links = tuple(name for links in names.links_between.values() for name in links)
    return SdfJoints(tuple(joints), floating, added_links, stance)


@dataclass(frozen=True, slots=True, eq=False)
class _JointMaker:
    """A maker of the SDF joints of a joint or loop. `stance`: the value of each dof in the pose in which the
    links stand; `relations`: follower → relation."""

    names: SdfNames
    stance: Configuration
    relations: Mapping[str, Relation]

    def joints_of(self, joint: Joint | Loop, parent: str, child: str, pose: Array) -> Iterator[SdfJoint]:
        """Yields the joints from `parent` to `child`. `pose`: that of the first joint (4, 4) in the
        parent."""
        if not joint.dofs:
            name = self.names.joints[joint.name]
            yield SdfJoint(
                name,
                "fixed",
                parent,
                child,
                parent,
                pose,
                axis=None,
                limits=Limits(),
                dynamics=Dynamics(),
                follows=None,
                carries_child=True,
            )
        # The links that the dofs connect, one more than there are dofs.
        links = [parent, *self.names.links_between[joint.name], child]
        for dof, parent_of_dof, child_of_dof in zip(joint.dofs, links, links[1:], strict=False):
            value = self.stance[dof.name]
            yield SdfJoint(
                self.names.joints[dof.name],
                _joint_type(dof),
                parent_of_dof,
                child_of_dof,
                parent_of_dof,
                pose @ dof.origin @ motion(dof.kind, dof.axis, value),
                None if dof.kind == "ball" else dof.axis,
                dof.limits if isinstance(value, tuple) else dof.limits.mapped(1, -value),
                dof.dynamics,
                self._follows(dof),
                carries_child=True,
            )
            pose = np.eye(4)

    def _follows(self, dof: Dof) -> Mimic | None:
        """Returns the relation of a follower, with values counted from the pose in which the links stand."""
        relation = self.relations.get(dof.name)
        if relation is None:
            return None
        follower, driver = self.stance[relation.follower], self.stance[relation.driver]
        assert not isinstance(follower, tuple)
        assert not isinstance(driver, tuple)
        offset = relation.offset + relation.multiplier * driver - follower
        return Mimic(self.names.joints[relation.driver], relation.multiplier, offset)


def _with_exchanged_links(loop: Loop) -> Loop:
    """Returns the loop with its links exchanged: its dofs in reverse and their axes negated, so that turns
    and slides keep their values. A reader would hang the whole robot on a joint whose child is the root."""
    dofs = loop.dofs[::-1]
    origins = [np.eye(4), *(inverse(dof.origin) for dof in dofs)]
    return replace(
        loop,
        link_a=loop.link_b,
        link_b=loop.link_a,
        a_from_frame=loop.b_from_frame @ inverse(origins[-1]),
        b_from_frame=loop.a_from_frame,
        dofs=tuple(
            replace(dof, axis=-dof.axis, origin=origin) for dof, origin in zip(dofs, origins, strict=False)
        ),
    )


def _conjugated_values(exchanged: Iterable[Loop], stance: Configuration) -> dict[str, Value]:
    """Returns the values of the balls of exchanged loops: the conjugated quaternions."""
    balls = {dof.name: stance[dof.name] for loop in exchanged for dof in loop.dofs if dof.kind == "ball"}
    return {name: (q[0], -q[1], -q[2], -q[3]) for name, q in balls.items() if isinstance(q, tuple)}


def _stance(robot: Robot, start: Configuration) -> dict[str, Value]:
    """Returns the value of each dof, including those of loops, in the pose in which the links of the SDF
    stand."""
    stance: dict[str, Value] = {
        dof.name: start[dof.name] if dof.kind == "free" else at_rest(dof.kind) for dof in robot.dofs
    }
    poses = link_poses(robot, stance)
    if any(gap(loop, poses) > MAX_CLOSED_GAP for loop in robot.loops):
        paths = TreePaths(robot)
        on_loops = {dof.name for loop in robot.loops for dof in paths.dofs_of(loop)}
        stance |= {dof.name: start[dof.name] for dof in robot.dofs if dof.name in on_loops}
        poses = link_poses(robot, stance)
    for loop in robot.loops:
        stance |= closing_values(loop, relative_pose(loop, poses))
    return {name: value if _is_moved(value) else _zero_of(value) for name, value in stance.items()}


def _zero_of(value: Value) -> Value:
    """Returns the zero of a value's kind: the value of a dof that is not moved."""
    return at_rest("ball" if len(value) == 4 else "free") if isinstance(value, tuple) else 0.0


def _is_moved(value: Value) -> bool:
    """Tells whether a value is not zero, apart from rounding errors."""
    if not isinstance(value, tuple):
        return abs(value) > ZERO_TOLERANCE
    # The last three numbers are the vector part of a unit quaternion: the sine of half the angle.
    sine = math.hypot(*value[-3:])
    return sine > ZERO_TOLERANCE or any(abs(component) > ZERO_TOLERANCE for component in value[:-4])


def _joint_type(dof: Dof) -> SdfJointType:
    """Returns the type of the SDF joint of a dof."""
    if dof.kind == "ball":
        return "ball"
    if dof.kind == "slide":
        return "prismatic"
    return "continuous" if dof.limits.lower is None and dof.limits.upper is None else "revolute"
