"""Type, limits, effort and dynamics of each joint."""

from collections.abc import Iterator
from typing import Any

from stages.robot.check import Check
from stages.robot.model import Dof
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import SAME, joint_index, joints_of

CODE = "C-JOINT"

OPEN = 1e6
"""The end of a range from here on stands for no limit [rad, m]."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """A URDF may limit a dof without limits, since it requires a range."""
    wrong = [
        name
        for name, kind, dof in joints_of(compiled.robot, compiled.urdf)
        if not _fits(compiled.model, joint_index(compiled.model, name), kind, dof, compiled.urdf)
    ]
    detail = f"differ: {', '.join(wrong)}" if wrong else "type, limits, effort and dynamics of each joint"
    yield compiled.within("joints", float(len(wrong)), 0.0, detail)


def _fits(model: Any, index: int, kind: Any, dof: Dof, urdf: bool) -> bool:
    if model.jnt_type[index] != kind:
        return False
    if dof.kind == "free":
        return not model.jnt_limited[index]
    if dof.kind == "ball":
        # No format has a ball's cone: neither its joint nor the three turns of a URDF may have limits.
        return not model.jnt_limited[index] and _has_dynamics(model, index, dof, urdf)
    return _has_limits(model, index, dof, urdf) and _has_dynamics(model, index, dof, urdf)


def _has_limits(model: Any, index: int, dof: Dof, urdf: bool) -> bool:
    """Whether a hinge or slide has the limits and effort of its dof."""
    low, high = model.jnt_range[index]
    sides = ((dof.limits.lower, low, -1), (dof.limits.upper, high, 1))
    limited = any(side is not None for side, *_ in sides)
    fits = urdf or model.jnt_limited[index] == limited
    fits &= all(side is None or abs(side - value) <= SAME * max(1, abs(side)) for side, value, _ in sides)
    fits &= urdf or not limited or all(value * sign >= OPEN for side, value, sign in sides if side is None)
    effort = dof.dynamics.effort
    fits &= effort is None or abs(model.jnt_actfrcrange[index][1] - effort) <= SAME * effort
    return bool(fits)


def _has_dynamics(model: Any, index: int, dof: Dof, urdf: bool) -> bool:
    """Whether a joint has the damping, friction and armature of its dof; URDF has no armature."""
    expected, at = dof.dynamics, int(model.jnt_dofadr[index])
    pairs = [(expected.damping, model.dof_damping), (expected.friction, model.dof_frictionloss)]
    pairs += [] if urdf else [(expected.armature, model.dof_armature)]
    return all(
        abs((value or 0.0) - float(found[at])) <= SAME * max(1.0, value or 0.0) for value, found in pairs
    )
