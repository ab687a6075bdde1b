"""Checks the keyframes of an MJCF: the number of their values, and that these are within limits."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from linkwright.stages.formats.mjcf.controls import control_count
from linkwright.stages.formats.xml import Element
from linkwright.stages.validate.bare.findings import Coded, numbers
from linkwright.stages.validate.bare.mjcf_defaults import Defaults
from linkwright.stages.validate.bare.mjcf_values import degrees_of
from linkwright.stages.validate.reading.documents import MAKERS, ModelDocument

_COORDINATES = {"hinge": 1, "slide": 1, "ball": 4, "free": 7}
_VELOCITIES = {"hinge": 1, "slide": 1, "ball": 3, "free": 6}

UNIT_LENGTH_TOLERANCE = 1e-2
"""Tolerance of the length of a unit quaternion."""

RANGE_TOLERANCE = 1e-3
"""Tolerance [rad, m] for coordinates beyond their range: files have few digits."""


@dataclass(frozen=True, slots=True, eq=False)
class _Coordinate:
    """A joint of the model."""

    name: str
    kind: str
    first: int
    """The index of the joint's first number in qpos."""

    ends: tuple[float, float] | None
    """The range [rad, m]; None without limits."""


def check(document: ModelDocument) -> Iterator[Coded]:
    """Judges the sizes of qpos, qvel and ctrl, the quaternions in qpos, and values beyond a joint's range.
    Skips files with elements that make other elements: their sizes are not in the text."""
    keys = [key for key in document.root.iterfind("keyframe/key") if key not in document.included]
    if not keys or any(element.tag in MAKERS for element in document.root.iter()):
        return
    defaults = Defaults(document.root)
    joints = list(_coordinates(document, defaults))
    nq = sum(_COORDINATES[joint.kind] for joint in joints)
    nv = sum(_VELOCITIES[joint.kind] for joint in joints)
    nu = sum(
        control_count(str(actuator.tag), defaults.attributes(actuator).get("input"))
        for actuator in document.root.iterfind("actuator/*")
    )
    for key in keys:
        for name, expected in (("qpos", nq), ("qvel", nv), ("ctrl", nu)):
            values = numbers(key.get(name))
            if values is not None and len(values) != expected:
                message = f"it has {len(values)} numbers, the model {expected}"
                yield "C-KEYS", document.finding(key, name, message)
            elif values is not None and name == "qpos":
                yield from _qpos(document, key, values, joints)


def _qpos(
    document: ModelDocument, key: Element, values: list[float], joints: list[_Coordinate]
) -> Iterator[Coded]:
    for joint in joints:
        if joint.kind in ("ball", "free"):
            first = joint.first + (3 if joint.kind == "free" else 0)
            length = math.hypot(*values[first : first + 4])
            if abs(length - 1.0) > UNIT_LENGTH_TOLERANCE:
                message = f'the quaternion of "{joint.name}" has the length {length:.4g}, expected 1'
                yield "C-KEYS" if length < 1e-10 else "C-PLAUSIBLE", document.finding(key, "qpos", message)
        elif joint.ends is not None:
            value, (low, high) = values[joint.first], joint.ends
            if not low - RANGE_TOLERANCE <= value <= high + RANGE_TOLERANCE:
                message = f'"{joint.name}" is at {value:g}, outside its range {low:g} to {high:g}'
                yield "C-PLAUSIBLE", document.finding(key, "qpos", message)


def _coordinates(document: ModelDocument, defaults: Defaults) -> Iterator[_Coordinate]:
    degrees, first = degrees_of(document), 0
    for element in document.root.iterfind("worldbody//*"):
        if element.tag not in ("joint", "freejoint"):
            continue
        attributes = defaults.attributes(element) if element.tag == "joint" else {"type": "free"}
        kind = attributes.get("type", "hinge")
        if kind not in _COORDINATES:
            continue
        ends = numbers(attributes.get("range"))
        limited = attributes.get("limited", "auto") != "false" and ends is not None and len(ends) == 2
        pair = None
        if limited and ends is not None and ends[0] < ends[1] and kind in ("hinge", "slide"):
            unit = math.pi / 180.0 if degrees and kind == "hinge" else 1.0
            pair = ends[0] * unit, ends[1] * unit
        yield _Coordinate(str(element.get("name", kind)), kind, first, pair)
        first += _COORDINATES[kind]
