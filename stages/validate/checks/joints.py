"""Type, limits, effort and dynamics of each joint; nothing else acts on it."""

import math
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from stages.formats.xml import parse
from stages.robot.check import Check, Finding
from stages.robot.model import Dof
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import SAME, joint_index, joints_of
from stages.validate.findings import differs, few, named, shown

CODE = "C-JOINT"

UNTOUCHED = (
    ("stiffness", "jnt_stiffness", 0.0),
    ("margin", "jnt_margin", 0.0),
    ("solreflimit", "jnt_solref", (0.02, 1.0)),
    ("solimplimit", "jnt_solimp", (0.9, 0.95, 0.001, 0.5, 2.0)),
)
"""Attributes of an MJCF's joint that no robot has, where they are in a model, and MuJoCo's defaults."""

POLYNOMIALS = (("stiffness", "jnt_stiffnesspoly", "jnt"), ("damping", "dof_dampingpoly", "dof"))
"""As `UNTOUCHED`: the terms of higher order, of a joint or of a dof, which older versions of MuJoCo lack."""

OPEN = 1e6
"""The end of a range from here on stands for no limit [rad, m]."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """A URDF may limit a dof without limits, since it requires a range."""
    found: list[Finding] = []
    wrong = []
    velocities = _velocities(compiled) if compiled.urdf else {}
    for name, kind, dof in joints_of(compiled.robot, compiled.urdf):
        index = joint_index(compiled.model, name)
        own = list(_differences(compiled.model, index, name, kind, dof, compiled.urdf))
        own += _velocity(name, dof, velocities.get(name)) if compiled.urdf else _more(compiled, index, name)
        found += own
        wrong += [name] if own else []
    detail = f"differ: {', '.join(wrong)}" if wrong else "type, limits, effort and dynamics of each joint"
    yield compiled.within("joints", float(len(wrong)), 0.0, detail, few(found))


def _velocities(compiled: CompiledModel) -> dict[str, str]:
    """By joint, as a URDF has them: MuJoCo leaves them out."""
    limits = parse(compiled.path.read_bytes()).iterfind("joint/limit")
    return {one.getparent().get("name", ""): one.get("velocity", "") for one in limits}


def _velocity(name: str, dof: Dof, text: str | None) -> Iterator[Finding]:
    expected = dof.dynamics.velocity
    if expected is None or dof.kind == "free":
        return
    try:
        found = float(text) if text else None
    except ValueError:
        found = math.nan
    if found is None:
        yield Finding(named("joint", name), "limit velocity", f"is missing, expected {shown(expected)}")
    elif not abs(found - expected) <= SAME * max(1.0, expected):
        yield differs(named("joint", name), "limit velocity", found, expected)


def _differences(model: Any, index: int, name: str, kind: Any, dof: Dof, urdf: bool) -> Iterator[Finding]:
    element = named("joint", name)
    if model.jnt_type[index] != kind:
        yield differs(element, "type", _type(model.jnt_type[index]), _type(kind))
        return
    if dof.kind in ("free", "ball") and model.jnt_limited[index]:
        # No format has a ball's cone: neither its joint nor the three turns of a URDF may have limits.
        attribute = "limit" if urdf else "range"
        yield Finding(element, attribute, f"is {shown(model.jnt_range[index])}, expected none")
    if dof.kind in ("turn", "slide"):
        yield from _limits(model, index, element, dof, urdf)
    if dof.kind != "free":
        yield from _dynamics(model, index, element, dof, urdf)


def _type(kind: Any) -> str:
    return str(mujoco.mjtJoint(int(kind)).name).removeprefix("mjJNT_").lower()


def _limits(model: Any, index: int, element: str, dof: Dof, urdf: bool) -> Iterator[Finding]:
    """What a hinge or slide has of the limits and effort of its dof otherwise."""
    ends = [float(end) for end in model.jnt_range[index]]
    sides = tuple(zip(("lower", "upper"), dof.limits.interval, ends, strict=True))
    limited = dof.limits.lower is not None or dof.limits.upper is not None
    unit = "rad" if dof.kind == "turn" else "m"
    if urdf:
        for side, expected, found in sides:
            if abs(expected) < OPEN and not _same_end(found, expected):
                yield differs(element, f"limit {side}", found, expected, unit)
    elif limited != bool(model.jnt_limited[index]) or (
        limited and not all(_same_end(found, expected) for _, expected, found in sides)
    ):
        both = (ends if model.jnt_limited[index] else None, dof.limits.interval if limited else None)
        yield differs(element, "range", *both, unit)
    yield from _effort(model, index, element, dof.dynamics.effort, urdf)


def _effort(model: Any, index: int, element: str, effort: float | None, urdf: bool) -> Iterator[Finding]:
    """A URDF may have an effort where the robot has none, since it requires one."""
    attribute, limited = "limit effort" if urdf else "actuatorfrcrange", bool(model.jnt_actfrclimited[index])
    low, high = (float(end) for end in model.jnt_actfrcrange[index])
    if effort is None:
        if limited and not urdf:
            yield differs(element, attribute, (low, high), None)
    elif not urdf and not limited:
        yield differs(element, attribute, None, (-effort, effort))
    elif not abs(high - effort) <= SAME * effort:
        yield differs(element, attribute, high, effort)
    elif not urdf and not abs(low + effort) <= SAME * effort:
        yield differs(element, attribute, (low, high), (-effort, effort))


def _same_end(found: float, expected: float) -> bool:
    if abs(expected) >= OPEN:
        return found * expected > 0 and abs(found) >= OPEN
    return abs(found - expected) <= SAME * max(1, abs(expected))


def _dynamics(model: Any, index: int, element: str, dof: Dof, urdf: bool) -> Iterator[Finding]:
    """What a joint has of the damping, friction and armature of its dof otherwise; URDF has no armature."""
    expected, at = dof.dynamics, int(model.jnt_dofadr[index])
    before, friction = ("dynamics ", "friction") if urdf else ("", "frictionloss")
    rows = [
        (f"{before}damping", expected.damping, model.dof_damping),
        (f"{before}{friction}", expected.friction, model.dof_frictionloss),
    ]
    rows += [] if urdf else [("armature", expected.armature, model.dof_armature)]
    for attribute, value, numbers in rows:
        wanted, found = value or 0.0, float(numbers[at])
        if not abs(wanted - found) <= SAME * max(1.0, wanted):
            yield differs(element, attribute, found, wanted)


def _more(compiled: CompiledModel, index: int, name: str) -> Iterator[Finding]:
    """What acts on a joint of an MJCF that is nothing of the robot's: springs, limits that are soft or begin
    early, and damping that is not linear."""
    model, element = compiled.model, named("joint", name)
    rows = [(attribute, getattr(model, field)[index], wanted) for attribute, field, wanted in UNTOUCHED]
    for attribute, field, of in POLYNOMIALS:
        at = index if of == "jnt" else int(model.jnt_dofadr[index])
        rows += [(attribute, getattr(model, field)[at], 0.0)] if hasattr(model, field) else []
    for attribute, found, wanted in rows:
        if np.array_equal(found, wanted) or compiled.sets(attribute):
            continue
        if not np.allclose(found, wanted, rtol=SAME, atol=SAME):
            word = "has terms of higher order:" if np.size(found) > 1 and wanted == 0.0 else "is"
            yield Finding(element, attribute, f"{word} {shown(found)}, expected {shown(wanted)}")
