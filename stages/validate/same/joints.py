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


def compare_joints(read_robot: ReadRobot) -> Iterator[Check]:
    """Yields a single result, whose value is the number of joints that differ."""
    findings_by_joint: dict[str, list[Finding]] = {}
    for joint in read_robot.joints():
        findings = list(_differences(read_robot, joint))
        findings_by_joint |= {joint.name: findings} if findings else {}
    detail = "type, limits, effort and dynamics of each joint"
    if findings_by_joint:
        detail = f"differ: {', '.join(findings_by_joint)}"
    findings = [finding for findings_of_joint in findings_by_joint.values() for finding in findings_of_joint]
    yield read_robot.within("joints", float(len(findings_by_joint)), 0.0, detail, findings)


def _differences(read_robot: ReadRobot, joint: FoundJoint) -> Iterator[Finding]:
    if joint.type not in joint.types:
        yield differs(joint.element, "type", joint.type, " or ".join(joint.types))
        return
    expected_of_dof = {} if joint.dof is None else expected(joint.dof)
    for quantity, actual in joint.numbers.items():
        expected_number = joint.expected.get(quantity, expected_of_dof.get(quantity, 0.0))
        # The file must have a number where the robot has no limit, and any number will do.
        if quantity in read_robot.required_numbers and expected_number in (math.inf, -math.inf):
            continue
        values, expected_values = (np.array(numbers, dtype=float) for numbers in (actual, expected_number))
        if quantity in ENDS:
            values, expected_values = _with_open_ends(values), _with_open_ends(expected_values)
        min_scale = 0.0 if quantity in FORCES else 1.0
        if not _is_same(values, expected_values, min_scale, read_robot.precision.number):
            attribute = read_robot.attribute_names.numbers.get(quantity, quantity)
            if quantity in read_robot.required_numbers and np.isinf(values).all():
                yield Finding(joint.element, attribute, f"is missing, expected {shown(expected_values)}")
                continue
            yield differs(
                joint.element, attribute, _shown(values), _shown(expected_values), _unit(quantity, joint.dof)
            )


def expected(dof: Dof) -> Numbers:
    """Returns the numbers that a file must have for a dof, by quantity. `cone` is the largest tilt of a ball
    [rad]."""
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


def _is_same(actual: Array, expected: Array, min_scale: float, tolerance: float) -> bool:
    """Tells whether values agree within `tolerance`, relative to the larger of the expected value and
    `min_scale`."""
    if actual.shape != expected.shape:
        return False
    with np.errstate(invalid="ignore"):
        is_near = np.abs(actual - expected) <= tolerance * np.maximum(min_scale, np.abs(expected))
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
