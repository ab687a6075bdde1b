"""Joints as URDF has them: of one degree of freedom each, over links of next to no mass."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from stages.formats.urdf.names import UrdfNames, urdf_names
from stages.robot.model import Array, Dof, Dynamics, Joint, Limits, Robot

StepType = Literal["fixed", "continuous", "revolute", "prismatic", "floating"]


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One URDF joint; `parent_from_step` (4, 4) is its origin, `axis` (3,) None where it has none."""

    name: str
    type: StepType
    parent: str
    child: str
    parent_from_step: Array
    axis: Array | None
    limits: Limits
    dynamics: Dynamics


@dataclass(frozen=True, slots=True, eq=False)
class Lowered:
    """A joint and what stands for it, from parent to child. `between`: the links that were made up."""

    joint: Joint
    steps: tuple[Step, ...]

    @property
    def between(self) -> tuple[str, ...]:
        return tuple(step.child for step in self.steps[:-1])


@dataclass(frozen=True, slots=True, eq=False)
class _Move:
    """A step without its place in the tree."""

    name: str
    type: StepType
    origin: Array
    axis: Array | None
    limits: Limits
    dynamics: Dynamics


def lower(robot: Robot) -> tuple[Lowered, ...]:
    """What URDF has for each joint, in the order of the joints.

    A turn or a slide is a joint of the dof's name; a ball is three turns `<name>_x`, `_y`, `_z`, about
    x, then y, then z: R = Rx Ry Rz. Links between them are `<joint>_<n>`.
    """
    names = urdf_names(robot)
    return tuple(_lowered(joint, names) for joint in robot.joints)


def unset(dof: Dof) -> list[str]:
    """What URDF demands of a dof and nobody gave: among lower, upper, effort, velocity."""
    if dof.kind == "free":
        return []
    missing: list[str] = []
    if dof.kind != "ball":
        missing = [side for side in ("lower", "upper") if getattr(dof.limits, side) is None]
    if dof.kind == "turn" and len(missing) == 2:
        missing = []  # continuous: URDF wants no range then
    return missing + [key for key in ("effort", "velocity") if getattr(dof.dynamics, key) is None]


def _lowered(joint: Joint, names: UrdfNames) -> Lowered:
    places = [joint.parent, *names.between[joint.name], joint.child]
    steps = []
    before = joint.parent_from_joint
    for move, parent, child in zip(_moves(joint, names), places, places[1:], strict=False):
        origin = before @ move.origin
        steps.append(Step(move.name, move.type, parent, child, origin, move.axis, move.limits, move.dynamics))
        before = np.eye(4)
    return Lowered(joint, tuple(steps))


def _moves(joint: Joint, names: UrdfNames) -> Iterator[_Move]:
    if not joint.dofs:
        yield _Move(joint.name, "fixed", np.eye(4), None, Limits(), Dynamics())
    for dof in joint.dofs:
        if dof.kind == "ball":
            yield from _turns(dof, names.turns[dof.name])
        else:
            axis = None if dof.kind == "free" else dof.axis
            yield _Move(dof.name, _type(dof), dof.origin, axis, dof.limits, dof.dynamics)


def _turns(dof: Dof, names: tuple[str, str, str]) -> Iterator[_Move]:
    """A ball as turns about x, y and z, without its cone."""
    origin = dof.origin
    for name, axis in zip(names, np.eye(3), strict=True):
        yield _Move(name, "continuous", origin, axis, Limits(), dof.dynamics)
        origin = np.eye(4)


def _type(dof: Dof) -> StepType:
    if dof.kind == "free":
        return "floating"
    if dof.kind == "slide":
        return "prismatic"
    return "continuous" if dof.limits.lower is None and dof.limits.upper is None else "revolute"
