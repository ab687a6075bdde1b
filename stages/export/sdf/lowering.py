"""Lowering: joints and loops of several degrees of freedom as SDF joints of one each, with links of next to
no mass between them; and the pose in which the links of the SDF stand."""

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
from linkwright.stages.robot.motion.loops import CLOSED, across, closing, gap
from linkwright.stages.robot.motion.tree_paths import Ways

SdfJointType = Literal["fixed", "continuous", "revolute", "prismatic", "ball"]


@dataclass(frozen=True, slots=True)
class Follows:
    """value = multiplier · (value of `joint`) + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True, eq=False)
class SdfJoint:
    """One SDF joint; links and joints by their names in the SDF.

    `place` (4, 4): its frame in that of the link `at`. `axis` (3,) is None where it has none. `limits`: from
    the pose in which the links stand. `carries`: whether the child stands in the joint's frame; the joint of
    a loop only holds it.
    """

    name: str
    type: SdfJointType
    parent: str
    child: str
    at: str
    place: Array
    axis: Array | None
    limits: Limits
    dynamics: Dynamics
    follows: Follows | None
    carries: bool


@dataclass(frozen=True, slots=True, eq=False)
class SdfJoints:
    """The joints of an SDF, in the order of the robot's joints and then of its loops.

    `floating`: the links that no joint holds, each with the link in whose frame it stands and its pose
    (4, 4) there. `between`: the links added between those of the robot. `stands`: the value of each dof in
    the pose in which the links stand, those of loops too, which is the zero of every SDF joint.
    """

    joints: tuple[SdfJoint, ...]
    floating: Mapping[str, tuple[str, Array]]
    between: tuple[str, ...]
    stands: Configuration

    @property
    def moved(self) -> dict[str, Value]:
        """The dofs whose zero in the SDF is not the robot's, with the value that it is there."""
        return {name: value for name, value in self.stands.items() if _is_off(value)}


def lower(robot: Robot, start: Configuration, names: SdfNames) -> SdfJoints:
    """The SDF joints of each joint and loop. `start`: a value for each dof at which the loops are closed.

    A turn or a slide is a joint of its dof's name, a ball is a ball. An SDF's joint is at zero as its links
    stand, so these stand where loops are closed: at zero if they are closed there, else at `start`.
    """
    stands = _stance(robot, start)
    turned = {loop.name: _turned(loop) for loop in robot.loops if loop.link_a == robot.root.name}
    values = stands | _conjugated(turned.values(), stands)
    made = _Chains(names, values, {relation.follower: relation for relation in robot.relations})
    joints: list[SdfJoint] = []
    floating: dict[str, tuple[str, Array]] = {}
    for joint in robot.joints:
        parent, child = names.links[joint.parent], names.links[joint.child]
        if joint.type == "free":
            (dof,) = joint.dofs
            moved = dof.origin @ motion(dof.kind, dof.axis, stands[dof.name])
            floating[child] = (parent, joint.parent_from_joint @ moved)
        else:
            joints += made.of(joint, parent, child, joint.parent_from_joint)
    for loop in (turned.get(one.name, one) for one in robot.loops):
        # From its second link to its first, which stands where the tree has it.
        first = names.links[loop.link_a]
        *before, last = made.of(loop, names.links[loop.link_b], first, loop.b_from_frame)
        joints += [*before, replace(last, at=first, place=loop.a_from_frame, carries=False)]
    between = tuple(name for added in names.between.values() for name in added)
    return SdfJoints(tuple(joints), floating, between, stands)


@dataclass(frozen=True, slots=True, eq=False)
class _Chains:
    """What makes the SDF joints of a joint or loop. `relations`: by follower."""

    names: SdfNames
    stands: Configuration
    relations: Mapping[str, Relation]

    def of(self, one: Joint | Loop, parent: str, child: str, before: Array) -> Iterator[SdfJoint]:
        """The joints from `parent` to `child`, the first of which is at `before` (4, 4) in the parent."""
        if not one.dofs:
            name = self.names.joints[one.name]
            nothing = Limits(), Dynamics(), None
            yield SdfJoint(name, "fixed", parent, child, parent, before, None, *nothing, carries=True)
        links = [parent, *self.names.between[one.name], child]
        for dof, above, below in zip(one.dofs, links, links[1:], strict=False):
            value = self.stands[dof.name]
            yield SdfJoint(
                self.names.joints[dof.name],
                _type(dof),
                above,
                below,
                above,
                before @ dof.origin @ motion(dof.kind, dof.axis, value),
                None if dof.kind == "ball" else dof.axis,
                dof.limits if isinstance(value, tuple) else dof.limits.mapped(1, -value),
                dof.dynamics,
                self._follows(dof),
                carries=True,
            )
            before = np.eye(4)

    def _follows(self, dof: Dof) -> Follows | None:
        """The relation of a follower, of values counted from where the links stand."""
        relation = self.relations.get(dof.name)
        if relation is None:
            return None
        follower, driver = self.stands[relation.follower], self.stands[relation.driver]
        assert not isinstance(follower, tuple)
        assert not isinstance(driver, tuple)
        offset = relation.offset + relation.multiplier * driver - follower
        return Follows(self.names.joints[relation.driver], relation.multiplier, offset)


def _turned(loop: Loop) -> Loop:
    """The loop from its first link to its second: dofs in reverse, axes negated, so that turns and slides
    keep their values. For a reader, a joint whose child is the root makes it hang on what hangs on it."""
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


def _conjugated(turned: Iterable[Loop], stands: Configuration) -> dict[str, Value]:
    """The values of balls the other way round."""
    balls = {dof.name: stands[dof.name] for loop in turned for dof in loop.dofs if dof.kind == "ball"}
    return {name: (q[0], -q[1], -q[2], -q[3]) for name, q in balls.items() if isinstance(q, tuple)}


def _stance(robot: Robot, start: Configuration) -> dict[str, Value]:
    """The value of each dof in the pose in which the links of the SDF stand."""
    stands: dict[str, Value] = {
        dof.name: start[dof.name] if dof.kind == "free" else at_rest(dof.kind) for dof in robot.dofs
    }
    poses = link_poses(robot, stands)
    if any(gap(loop, poses) > CLOSED for loop in robot.loops):
        ways = Ways(robot)
        on_loops = {dof.name for loop in robot.loops for dof in ways.dofs_of(loop)}
        stands |= {dof.name: start[dof.name] for dof in robot.dofs if dof.name in on_loops}
        poses = link_poses(robot, stands)
    for loop in robot.loops:
        stands |= closing(loop, across(loop, poses))
    return {name: value if _is_off(value) else _rest(value) for name, value in stands.items()}


def _rest(value: Value) -> Value:
    """The value without the rounding that it has around no motion."""
    return at_rest("ball" if len(value) == 4 else "free") if isinstance(value, tuple) else 0.0


def _is_off(value: Value) -> bool:
    """Whether a dof at this value is moved."""
    if not isinstance(value, tuple):
        return abs(value) > ROUNDING
    sine = math.hypot(*value[-3:])
    return sine > ROUNDING or any(abs(one) > ROUNDING for one in value[:-4])


ROUNDING = 1e-12
"""A loop that is closed at zero is closed there up to this [m, rad]."""


def _type(dof: Dof) -> SdfJointType:
    if dof.kind == "ball":
        return "ball"
    if dof.kind == "slide":
        return "prismatic"
    return "continuous" if dof.limits.lower is None and dof.limits.upper is None else "revolute"
