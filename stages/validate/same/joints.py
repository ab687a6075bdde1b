"""Compares the type and the numbers of each joint: limits, effort and dynamics."""

import math
from collections.abc import Iterator

import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Array, Dof, Limits
from linkwright.stages.validate.findings import differs, shown
from linkwright.stages.validate.same.read_robot import FoundJoint, Numbers, ReadRobot

UNLIMITED = 1e6
"""Value [rad, m] from which the end of a range counts as no limit."""

ENDS = ("lower", "upper", "range")
"""Quantities that are ends of ranges."""

FORCES = ("effort", "actuatorfrcrange")
"""Quantities that are compared relative to their value, however small it is."""


def compare_joints(read: ReadRobot) -> Iterator[Check]:
    """Yields a single result."""
    wrong: dict[str, list[Finding]] = {}
    for joint in read.joints():
        findings = list(_differences(read, joint))
        wrong |= {joint.name: findings} if findings else {}
    detail = f"differ: {', '.join(wrong)}" if wrong else "type, limits, effort and dynamics of each joint"
    findings = [finding for of_joint in wrong.values() for finding in of_joint]
    yield read.within("joints", float(len(wrong)), 0.0, detail, findings)


def _differences(read: ReadRobot, joint: FoundJoint) -> Iterator[Finding]:
    if joint.type not in joint.types:
        yield differs(joint.element, "type", joint.type, " or ".join(joint.types))
        return
    of_dof = {} if joint.dof is None else expected(joint.dof)
    for quantity, actual in joint.numbers.items():
        number = joint.expected.get(quantity, of_dof.get(quantity, 0.0))
        if quantity in read.required_numbers and number in (math.inf, -math.inf):
            continue
        values, goals = (np.array(numbers, dtype=float) for numbers in (actual, number))
        if quantity in ENDS:
            values, goals = _with_open_ends(values), _with_open_ends(goals)
        if not _is_same(values, goals, 0.0 if quantity in FORCES else 1.0, read.precision.number):
            attribute = read.attribute_names.numbers.get(quantity, quantity)
            if quantity in read.required_numbers and np.isinf(values).all():
                yield Finding(joint.element, attribute, f"is missing, expected {shown(goals)}")
                continue
            yield differs(joint.element, attribute, _shown(values), _shown(goals), _unit(quantity, joint.dof))


def expected(dof: Dof) -> Numbers:
    """Returns the numbers that a file must have for a dof, by quantity. `cone` is the tilt of a ball."""
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


def _is_same(actual: Array, expected: Array, least: float, exact: float) -> bool:
    """Tells whether values agree within `exact`, relative to the larger of the expected value and `least`."""
    if actual.shape != expected.shape:
        return False
    with np.errstate(invalid="ignore"):
        is_near = np.abs(actual - expected) <= exact * np.maximum(least, np.abs(expected))
    return bool(((actual == expected) | (is_near & np.isfinite(expected))).all())


def _with_open_ends(ends: Array) -> Array:
    return np.where(np.abs(ends) >= UNLIMITED, np.copysign(np.inf, ends), ends)


def _shown(value: Array) -> object:
    """Returns a value for a message. An infinite number, or a range without ends, is shown as missing."""
    return None if np.isinf(value).all() else value


def _unit(quantity: str, dof: Dof | None) -> str:
    if quantity not in ENDS or dof is None:
        return ""
    return "m" if dof.kind == "slide" else "rad"
