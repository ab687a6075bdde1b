"""Checks the numbers of an MJCF: those of its joints, bodies and actuators."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from linkwright.stages.formats.xml import Element
from linkwright.stages.validate.bare.findings import CodedFinding, parse_number, parse_numbers
from linkwright.stages.validate.bare.judged import inertia_faults, looks_like_degrees, mass_faults
from linkwright.stages.validate.bare.mjcf_defaults import Defaults
from linkwright.stages.validate.model.inertials import MAX_DUMMY_MASS
from linkwright.stages.validate.reading.documents import ModelDocument

_RESISTANCE_ATTRIBUTES = ("damping", "frictionloss", "armature", "stiffness")
"""Attributes of a joint that must not be negative."""


def check(document: ModelDocument) -> Iterator[CodedFinding]:
    """Judges directions, ranges, resistances, masses and inertias below the world, and actuators."""
    defaults = Defaults(document.root)
    degrees = degrees_of(document)
    for element in document.elements():
        if any(above.tag == "worldbody" for above in element.iterancestors()):
            attributes = defaults.attributes(element)
            yield from _orientation(document, element)
            if element.tag == "joint":
                yield from _joint(document, element, attributes, degrees)
            elif element.tag == "inertial":
                yield from _inertial(document, element)
            elif element.tag == "geom":
                yield from _geom(document, element, attributes)
        elif element.getparent() is not None and element.getparent().tag == "actuator":
            yield from _actuator(document, element, defaults.attributes(element))
    yield from _radian_ranges(document, defaults, degrees)


def degrees_of(document: ModelDocument) -> bool:
    """Tells whether angles are in degrees, which is the default of the compiler."""
    angle = "degree"
    for compiler in document.root.iterfind("compiler"):
        angle = compiler.get("angle", angle)
    return angle == "degree"


def _orientation(document: ModelDocument, element: Element) -> Iterator[CodedFinding]:
    quat = parse_numbers(element.get("quat"))
    # A quaternion of any other length is right: MuJoCo normalizes it.
    if quat is not None and len(quat) == 4 and math.hypot(*quat) < 1e-10:
        yield "C-DIRECTION", document.finding(element, "quat", "its length is 0: it is no rotation")


def _joint(
    document: ModelDocument, element: Element, attributes: Mapping[str, str], degrees: bool
) -> Iterator[CodedFinding]:
    kind = attributes.get("type", "hinge")
    axis = parse_numbers(attributes.get("axis"))
    if kind in ("hinge", "slide") and axis is not None and len(axis) == 3 and math.hypot(*axis) < 1e-10:
        yield "C-DIRECTION", document.finding(element, "axis", "its length is 0: it has no direction")
    for name in _RESISTANCE_ATTRIBUTES:
        value = parse_numbers(attributes.get(name))
        if value is not None and value[0] < 0:
            message = f"{value[0]:g} is negative: it would push the joint"
            yield "C-LIMIT", document.finding(element, name, message)
    for name in ("range", "actuatorfrcrange"):
        yield from _range_order(document, element, attributes, name)
    ends = parse_numbers(attributes.get("range")) or []
    if kind == "hinge" and not degrees and any(looks_like_degrees(end) for end in ends):
        message = f"{attributes['range']} rad: is it in degrees?"
        yield "C-PLAUSIBLE", document.finding(element, "range", message)


def _range_order(
    document: ModelDocument, element: Element, attributes: Mapping[str, str], name: str
) -> Iterator[CodedFinding]:
    ends = parse_numbers(attributes.get(name))
    if ends is not None and len(ends) == 2 and ends[0] >= ends[1] and any(ends):
        relation = "is above" if ends[0] > ends[1] else "equals"
        message = f"its lower end {ends[0]:g} {relation} its upper end {ends[1]:g}"
        yield "C-LIMIT", document.finding(element, name, message)


def _inertial(document: ModelDocument, element: Element) -> Iterator[CodedFinding]:
    mass, body = parse_number(element.get("mass")), element.getparent()
    moves = body is not None and any(child.tag in ("joint", "freejoint") for child in body)
    if mass is not None:
        for message in mass_faults(mass, moves):
            yield "C-SOLID", document.finding(element, "mass", message)
    diagonal, full = parse_numbers(element.get("diaginertia")), parse_numbers(element.get("fullinertia"))
    # A body that never moves, or that only stands for a frame, may have no inertia.
    may_be_massless = not moves or (mass is not None and 0 <= mass <= MAX_DUMMY_MASS)
    if may_be_massless and not any([*(diagonal or []), *(full or [])]):
        return
    if diagonal is not None and len(diagonal) == 3:
        for _, message in inertia_faults(np.diag(diagonal)):
            yield "C-SOLID", document.finding(element, "diaginertia", message)
    if full is not None and len(full) == 6:
        xx, yy, zz, xy, xz, yz = full
        for _, message in inertia_faults(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])):
            yield "C-SOLID", document.finding(element, "fullinertia", message)


def _geom(document: ModelDocument, element: Element, attributes: Mapping[str, str]) -> Iterator[CodedFinding]:
    for name in ("mass", "density"):
        value = parse_number(attributes.get(name))
        if value is not None and value < 0:
            yield "C-SOLID", document.finding(element, name, f"{value:g} is negative")
    size = parse_numbers(attributes.get("size"))
    if size is not None and attributes.get("type") not in ("plane", "mesh", "hfield") and min(size) < 0:
        yield "C-LIMIT", document.finding(element, "size", f"{attributes['size']}: a size is above zero")


def _actuator(
    document: ModelDocument, element: Element, attributes: Mapping[str, str]
) -> Iterator[CodedFinding]:
    for name in ("ctrlrange", "forcerange"):
        yield from _range_order(document, element, attributes, name)
    for name in ("kp", "kv"):
        value = parse_number(attributes.get(name))
        if value is not None and (value < 0 or (name == "kp" and value == 0)):
            yield "C-LIMIT", document.finding(element, name, f"{value:g}: a gain is above zero")
    if element.tag in ("position", "motor", "velocity") and not _has_control_range(attributes):
        message = "it has no range: a control may be anything"
        yield "C-PLAUSIBLE", document.finding(element, "ctrlrange", message)


def _has_control_range(attributes: Mapping[str, str]) -> bool:
    return "ctrlrange" in attributes or parse_number(attributes.get("inheritrange", "0")) not in (0.0, None)


def _radian_ranges(document: ModelDocument, defaults: Defaults, degrees: bool) -> Iterator[CodedFinding]:
    """Yields a finding if the ranges of hinges seem to be in radians although the compiler reads degrees: all
    are within ±2π."""
    hinges = []
    for element in document.root.iterfind("worldbody//joint"):
        attributes = defaults.attributes(element)
        if attributes.get("type", "hinge") == "hinge" and "range" in attributes:
            hinges.append((element, parse_numbers(attributes["range"]) or [0.0]))
    if degrees and hinges and all(max(map(abs, ends)) <= 2.0 * math.pi + 0.01 for _, ends in hinges):
        element, ends = hinges[0]
        if element in document.included:
            return
        message = f"{ends[0]:g} to {ends[-1]:g} degrees: is it in radians? (compiler angle)"
        yield "C-PLAUSIBLE", document.finding(element, "range", message)
