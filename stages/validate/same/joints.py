"""Type and numbers of each joint: limits, effort and dynamics; nothing else acts on it."""

import math
from collections.abc import Iterator

import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Array, Dof, Limits
from linkwright.stages.validate.findings import differs, shown
from linkwright.stages.validate.same.found import FoundJoint, Numbers, ReadRobot

OPEN = 1e6
"""The end of a range from here on stands for no limit [rad, m]."""

ENDS = ("lower", "upper", "range")
"""Quantities that are ends of ranges."""

FORCES = ("effort", "actuatorfrcrange")
"""Quantities of which a small one is as exact as a large one."""


def joints(read: ReadRobot) -> Iterator[Check]:
    """One result."""
    wrong: dict[str, list[Finding]] = {}
    for joint in read.joints():
        found = list(_differences(read, joint))
        wrong |= {joint.name: found} if found else {}
    detail = f"differ: {', '.join(wrong)}" if wrong else "type, limits, effort and dynamics of each joint"
    findings = [finding for every in wrong.values() for finding in every]
    yield read.within("joints", float(len(wrong)), 0.0, detail, findings)


def _differences(read: ReadRobot, joint: FoundJoint) -> Iterator[Finding]:
    if joint.type not in joint.types:
        yield differs(joint.element, "type", joint.type, " or ".join(joint.types))
        return
    of_dof = {} if joint.dof is None else expected(joint.dof)
    for quantity, found in joint.numbers.items():
        wanted = joint.wanted.get(quantity, of_dof.get(quantity, 0.0))
        if quantity in read.demands and wanted in (math.inf, -math.inf):
            continue
        values, goals = (np.array(one, dtype=float) for one in (found, wanted))
        if quantity in ENDS:
            values, goals = _opened(values), _opened(goals)
        if not _alike(values, goals, 0.0 if quantity in FORCES else 1.0, read.precision.number):
            attribute = read.words.numbers.get(quantity, quantity)
            if quantity in read.demands and np.isinf(values).all():
                yield Finding(joint.element, attribute, f"is missing, expected {shown(goals)}")
                continue
            yield differs(joint.element, attribute, _said(values), _said(goals), _unit(quantity, joint.dof))


def expected(dof: Dof) -> Numbers:
    """What a file has to say of a dof, by quantity; `cone`: of a ball, how far it tilts."""
    (low, high), dynamics = dof.limits.interval, dof.dynamics
    return {
        "lower": low,
        "upper": high,
        "cone": Limits(None, dof.limits.upper).interval[1],
        "effort": math.inf if dynamics.effort is None else dynamics.effort,
        "velocity": math.inf if dynamics.velocity is None else dynamics.velocity,
        "damping": dynamics.damping or 0.0,
        "friction": dynamics.friction or 0.0,
        "armature": dynamics.armature or 0.0,
    }


def _alike(found: Array, wanted: Array, least: float, exact: float) -> bool:
    """Within `exact`, relative to what is wanted, but to no less than `least`."""
    if found.shape != wanted.shape:
        return False
    with np.errstate(invalid="ignore"):
        near = np.abs(found - wanted) <= exact * np.maximum(least, np.abs(wanted))
    return bool(((found == wanted) | (near & np.isfinite(wanted))).all())


def _opened(ends: Array) -> Array:
    return np.where(np.abs(ends) >= OPEN, np.copysign(np.inf, ends), ends)


def _said(value: Array) -> object:
    """A number that is infinite is none; so is a range without ends."""
    return None if np.isinf(value).all() else value


def _unit(quantity: str, dof: Dof | None) -> str:
    if quantity not in ENDS or dof is None:
        return ""
    return "m" if dof.kind == "slide" else "rad"
