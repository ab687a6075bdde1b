"""Type, limits, effort and dynamics of each joint; nothing else acts on it."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from stages.formats.xml import parse
from stages.robot.check import Check, Finding
from stages.robot.mjcf_extras import NO_EXTRAS
from stages.robot.model import Dof, Spring
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import SAME, joint_index, joints_of
from stages.validate.findings import differs, few, named, shown

CODE = "C-JOINT"

DEFAULTS = (
    ("margin", "jnt_margin", (0.0,)),
    ("solreflimit", "jnt_solref", (0.02, 1.0)),
    ("solimplimit", "jnt_solimp", (0.9, 0.95, 0.001, 0.5, 2.0)),
)
"""Attributes of an MJCF's joint that only an MJCF source may set, where they are in a model, and MuJoCo's
defaults."""

POLYNOMIALS = (("stiffness", "jnt_stiffnesspoly", "jnt"), ("damping", "dof_dampingpoly", "dof"))
"""As `DEFAULTS`: the terms of higher order, of a joint or of a dof, which older versions of MuJoCo lack."""

OPEN = 1e6
"""The end of a range from here on stands for no limit [rad, m]."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """A URDF may limit a dof without limits, since it requires a range."""
    found: list[Finding] = []
    wrong = []
    velocities = _velocities(compiled) if compiled.urdf else {}
    extras = (compiled.robot.mjcf or NO_EXTRAS).attributes_of("joint")
    for name, kind, dof in joints_of(compiled.robot, compiled.urdf):
        index, more = joint_index(compiled.model, name), extras.get(name, {})
        own = list(_differences(compiled.model, index, name, kind, dof, compiled.urdf, more))
        if compiled.urdf:
            own += _velocity(name, dof, velocities.get(name))
        else:
            own += [*_spring(compiled, index, name, dof), *_more(compiled, index, name, more)]
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


def _differences(
    model: Any, index: int, name: str, kind: Any, dof: Dof, urdf: bool, more: Mapping[str, str]
) -> Iterator[Finding]:
    """`more`: what an MJCF source says of it."""
    element = named("joint", name)
    if model.jnt_type[index] != kind:
        yield differs(element, "type", _type(model.jnt_type[index]), _type(kind))
        return
    if dof.kind in ("free", "ball") and model.jnt_limited[index] and "range" not in more:
        # No format has a ball's cone: neither its joint nor the three turns of a URDF may have limits.
        attribute = "limit" if urdf else "range"
        yield Finding(element, attribute, f"is {shown(model.jnt_range[index])}, expected none")
    if dof.kind in ("turn", "slide"):
        yield from _limits(model, index, element, dof, urdf)
        if not {"actuatorfrcrange", "actuatorfrclimited"} & {*more}:
            yield from _effort(model, index, element, dof.dynamics.effort, urdf)
        else:
            yield from _own_effort(model, index, element, more)
    if dof.kind != "free":
        yield from _dynamics(model, index, element, dof, urdf)


def _type(kind: Any) -> str:
    return str(mujoco.mjtJoint(int(kind)).name).removeprefix("mjJNT_").lower()


def _limits(model: Any, index: int, element: str, dof: Dof, urdf: bool) -> Iterator[Finding]:
    """What a hinge or slide has of the limits of its dof otherwise."""
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


def _own_effort(model: Any, index: int, element: str, more: Mapping[str, str]) -> Iterator[Finding]:
    """What a joint has otherwise of the limits that its MJCF source says, none where it says so."""
    limited = bool(model.jnt_actfrclimited[index])
    ends = [float(end) for end in more.get("actuatorfrcrange", "").split()]
    if "actuatorfrclimited" in more:
        ends = []
    found = [float(end) for end in model.jnt_actfrcrange[index]] if limited else []
    if len(ends) != len(found) or not np.allclose(ends, found, rtol=SAME):
        yield differs(element, "actuatorfrcrange", found or None, ends or None)


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


def _spring(compiled: CompiledModel, index: int, name: str, dof: Dof) -> Iterator[Finding]:
    """What a joint of an MJCF has otherwise of the spring of its dof, or a spring that the dof has not."""
    model, spring = compiled.model, dof.spring or Spring(0.0)
    rows = [("stiffness", float(model.jnt_stiffness[index]), spring.stiffness)]
    if dof.spring is not None and dof.kind in ("turn", "slide"):
        rest = float(model.qpos_spring[model.jnt_qposadr[index]])
        rows.append(("springref", rest, spring.reference))
    for attribute, found, wanted in rows:
        if not abs(found - wanted) <= SAME * max(1.0, abs(wanted)) and not compiled.sets(attribute):
            yield differs(named("joint", name), attribute, found, wanted)


def _more(compiled: CompiledModel, index: int, name: str, extras: Mapping[str, str]) -> Iterator[Finding]:
    """What acts on a joint of an MJCF and is neither the robot's nor its MJCF source's: limits that are soft
    or begin early, and springs and damping that are not linear."""
    model, element = compiled.model, named("joint", name)
    for attribute, field, default in DEFAULTS:
        found, wanted = getattr(model, field)[index], _said(extras, attribute) or default
        if not np.allclose(found, wanted, rtol=SAME, atol=SAME) and not compiled.sets(attribute):
            yield differs(element, attribute, found, wanted)
    for attribute, field, of in POLYNOMIALS:
        if not hasattr(model, field) or compiled.sets(attribute):
            continue
        terms = np.ravel(getattr(model, field)[index if of == "jnt" else int(model.jnt_dofadr[index])])
        said = _said(extras, attribute)[1:]
        expected = np.array([*said, *[0.0] * (len(terms) - len(said))])
        if not np.allclose(terms, expected, rtol=SAME, atol=SAME):
            words = f"has terms of higher order: {shown(terms)}, expected {shown(expected)}"
            yield Finding(element, attribute, words)


def _said(extras: Mapping[str, str], attribute: str) -> tuple[float, ...]:
    """The numbers of an attribute of an MJCF source, () where it says nothing."""
    return tuple(float(number) for number in extras.get(attribute, "").split())
