"""Checks the numbers of a URDF: the axes, limits and dynamics of joints, and the inertials of links."""

import math
from collections.abc import Collection, Iterator

import numpy as np

from linkwright.stages.formats.xml import Element
from linkwright.stages.validate.bare.findings import CodedFinding, parse_number, parse_numbers
from linkwright.stages.validate.bare.judged import inertia_faults, looks_like_degrees, mass_faults
from linkwright.stages.validate.model.inertials import MAX_DUMMY_MASS
from linkwright.stages.validate.reading.documents import ModelDocument

MOVING_TYPES = ("revolute", "continuous", "prismatic", "planar")
"""Types of joints with an axis that they move about or along."""

_INERTIA_ATTRIBUTES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")

UNIT_LENGTH_TOLERANCE = 2e-2
"""Tolerance of the length of a unit axis or quaternion: many files have only three digits."""


def check(document: ModelDocument) -> Iterator[CodedFinding]:
    """Judges axes, limits and dynamics of joints; masses and inertias of links."""
    for joint in document.root.iterfind("joint"):
        if joint.get("type") in MOVING_TYPES:
            yield from _axis(document, joint)
            yield from _limit(document, joint)
            yield from _dynamics(document, joint)
    moving = _moving_links(document)
    yield from _missing_inertials(document, moving)
    for link in document.root.iterfind("link[inertial]"):
        yield from _inertial(document, link.find("inertial"), link.get("name") in moving)


def _axis(document: ModelDocument, joint: Element) -> Iterator[CodedFinding]:
    axis = joint.find("axis")
    vector = None if axis is None else parse_numbers(axis.get("xyz"))
    if vector is None or len(vector) != 3:
        return
    length = math.hypot(*vector)
    if length == 0.0:
        yield "C-DIRECTION", document.finding(axis, "xyz", "its length is 0: it has no direction")
    elif abs(length - 1.0) > UNIT_LENGTH_TOLERANCE:
        yield "C-PLAUSIBLE", document.finding(axis, "xyz", f"its length is {length:.4g}, expected 1")


def _limit(document: ModelDocument, joint: Element) -> Iterator[CodedFinding]:
    limit, kind = joint.find("limit"), joint.get("type")
    if limit is None:
        if kind in ("revolute", "prismatic"):
            hint = "; the type of a joint without limits is continuous" if kind == "revolute" else ""
            message = f"a {kind} joint needs <limit>{hint}"
            yield "C-LIMIT", document.finding(joint, "limit", message)
        return
    for name in ("effort", "velocity"):
        value = parse_number(limit.get(name))
        if value is not None and value < 0:
            yield "C-LIMIT", document.finding(limit, name, f"{value:g} is negative")
        elif value == 0 and kind != "planar":
            yield "C-PLAUSIBLE", document.finding(limit, name, "0: no actuator can move this joint")
    if kind not in ("revolute", "prismatic"):
        return
    lower, upper = parse_number(limit.get("lower", "0")), parse_number(limit.get("upper", "0"))
    if lower is None or upper is None:
        return
    if lower > upper:
        message = f"{lower:g} is above the upper limit {upper:g}"
        yield "C-LIMIT", document.finding(limit, "lower", message)
    elif lower == upper:
        message = f"the range is empty, {lower:g} to {upper:g}: a {kind} joint that cannot move"
        yield "C-PLAUSIBLE", document.finding(limit, "upper", message)
    for name, value in (("lower", lower), ("upper", upper)):
        if kind == "revolute" and looks_like_degrees(value):
            yield "C-PLAUSIBLE", document.finding(limit, name, f"{value:g} rad: is it in degrees?")


def _dynamics(document: ModelDocument, joint: Element) -> Iterator[CodedFinding]:
    dynamics = joint.find("dynamics")
    for name in ("damping", "friction"):
        value = None if dynamics is None else parse_number(dynamics.get(name))
        if value is not None and value < 0:
            message = f"{value:g} is negative: it would push the joint"
            yield "C-LIMIT", document.finding(dynamics, name, message)


def _moving_links(document: ModelDocument) -> set[str | None]:
    """Returns the names of the links that are children of moving joints."""
    return {
        joint.find("child").get("link")
        for joint in document.root.iterfind("joint[child]")
        if joint.get("type") in (*MOVING_TYPES, "floating")
    }


def _missing_inertials(document: ModelDocument, moving: Collection[str | None]) -> Iterator[CodedFinding]:
    """Yields a finding for each link that has colliders, is on a moving joint and has no inertial: some
    readers assume no mass, others 1 kg."""
    for link in document.root.iterfind("link[collision]"):
        if link.get("name") in moving and link.find("inertial") is None:
            message = "it moves and has shapes, but no <inertial>: readers assume 0 kg or 1 kg"
            yield "C-PLAUSIBLE", document.finding(link, "inertial", message)


def _inertial(document: ModelDocument, inertial: Element, moves: bool) -> Iterator[CodedFinding]:
    mass_element, inertia_element = inertial.find("mass"), inertial.find("inertia")
    mass = None if mass_element is None else parse_number(mass_element.get("value"))
    values = (
        []
        if inertia_element is None
        else [parse_number(inertia_element.get(name)) for name in _INERTIA_ATTRIBUTES]
    )
    moments = [value for value in values if value is not None and math.isfinite(value)]
    # A frame's stand-in, or a link that never moves, may have no mass and no inertia.
    may_be_massless = not moves or (mass is not None and mass <= MAX_DUMMY_MASS)
    massless = may_be_massless and mass is not None and mass >= 0 and not any(moments)
    if mass_element is None or (inertia_element is None and mass):
        missing = "mass" if mass_element is None else "inertia"
        yield "C-SOLID", document.finding(inertial, missing, f"<inertial> has no <{missing}>")
    if mass is not None and not massless:
        for message in mass_faults(mass, moves):
            yield "C-SOLID", document.finding(mass_element, "value", message)
    if len(moments) == 6 and not massless and mass != 0:
        xx, xy, xz, yy, yz, zz = moments
        for name, message in inertia_faults(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])):
            yield "C-SOLID", document.finding(inertia_element, name, message)
