"""Checks the keyframes of an MJCF: the number of their values, and that positions are within limits."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from linkwright.stages.formats.mjcf.controls import control_count
from linkwright.stages.formats.xml import Element
from linkwright.stages.validate.bare.findings import Coded, numbers
from linkwright.stages.validate.bare.mjcf_defaults import Defaults
from linkwright.stages.validate.bare.mjcf_values import degrees_of
from linkwright.stages.validate.reading.documents import MAKERS, ModelDocument

_QPOS_COUNTS = {"hinge": 1, "slide": 1, "ball": 4, "free": 7}
"""Type of a joint → the number of its values in qpos."""

_QVEL_COUNTS = {"hinge": 1, "slide": 1, "ball": 3, "free": 6}
"""Type of a joint → the number of its values in qvel."""

_ZERO_LENGTH = 1e-10
"""Length below which a quaternion has no direction."""

UNIT_LENGTH_TOLERANCE = 1e-2
"""Tolerance of the length of a unit quaternion."""

RANGE_TOLERANCE = 1e-3
"""Tolerance [rad, m] for coordinates beyond their range: files have few digits."""


@dataclass(frozen=True, slots=True, eq=False)
class _Joint:
    """A joint of the model."""

    name: str
    kind: str
    qpos_index: int
    """The index of the joint's first value in qpos."""

    limits: tuple[float, float] | None
    """The range [rad, m]; None for a joint without limits."""


def check(document: ModelDocument) -> Iterator[Coded]:
    """Checks the number of values in qpos, qvel and ctrl, the length of the quaternions in qpos, and that
    values are within the range of their joint. Files with elements that generate other elements are skipped,
    since the number of the generated joints is not in the text."""
    keys = [key for key in document.root.iterfind("keyframe/key") if key not in document.included]
    if not keys or any(element.tag in MAKERS for element in document.root.iter()):
        return
    defaults = Defaults(document.root)
    joints = list(_joints(document, defaults))
    nq = sum(_QPOS_COUNTS[joint.kind] for joint in joints)
    nv = sum(_QVEL_COUNTS[joint.kind] for joint in joints)
    nu = sum(
        control_count(str(actuator.tag), defaults.attributes(actuator).get("input"))
        for actuator in document.root.iterfind("actuator/*")
    )
    for key in keys:
        for name, expected in (("qpos", nq), ("qvel", nv), ("ctrl", nu)):
            values = numbers(key.get(name))
            if values is not None and len(values) != expected:
                message = f"it has {len(values)} numbers, but the model needs {expected}"
                yield "C-KEYS", document.finding(key, name, message)
            elif values is not None and name == "qpos":
                yield from _qpos(document, key, values, joints)


def _qpos(
    document: ModelDocument, key: Element, values: list[float], joints: list[_Joint]
) -> Iterator[Coded]:
    """Checks the values of qpos, whose number is right: unit quaternions, and joints within their limits."""
    for joint in joints:
        if joint.kind in ("ball", "free"):
            # The position of a free joint precedes its quaternion.
            start = joint.qpos_index + (3 if joint.kind == "free" else 0)
            length = math.hypot(*values[start : start + 4])
            if abs(length - 1.0) > UNIT_LENGTH_TOLERANCE:
                message = f'the quaternion of "{joint.name}" has the length {length:.4g}, expected 1'
                # MuJoCo normalises quaternions, but a quaternion of length 0 has no direction.
                code = "C-KEYS" if length < _ZERO_LENGTH else "C-PLAUSIBLE"
                yield code, document.finding(key, "qpos", message)
        elif joint.limits is not None:
            value, (low, high) = values[joint.qpos_index], joint.limits
            if not low - RANGE_TOLERANCE <= value <= high + RANGE_TOLERANCE:
                message = f'"{joint.name}" is at {value:g}, outside its range {low:g} to {high:g}'
                yield "C-PLAUSIBLE", document.finding(key, "qpos", message)


def _joints(document: ModelDocument, defaults: Defaults) -> Iterator[_Joint]:
    """Yields the joints in the order of their values in qpos."""
    degrees = degrees_of(document)
    qpos_index = 0
    for element in document.root.iterfind("worldbody//*"):
        if element.tag not in ("joint", "freejoint"):
            continue
        attributes = defaults.attributes(element) if element.tag == "joint" else {"type": "free"}
        kind = attributes.get("type", "hinge")
        if kind not in _QPOS_COUNTS:
            continue
        limits = _limits(attributes, degrees) if kind in ("hinge", "slide") else None
        yield _Joint(str(element.get("name", kind)), kind, qpos_index, limits)
        qpos_index += _QPOS_COUNTS[kind]


def _limits(attributes: Mapping[str, str], degrees: bool) -> tuple[float, float] | None:
    """Returns the range [rad, m] of a hinge or slide; None if it has none. `degrees`: whether the file's
    angles are in degrees."""
    limits = numbers(attributes.get("range"))
    if limits is None or len(limits) != 2 or attributes.get("limited", "auto") == "false":
        return None
    # An empty range is a fault of the joint, not of the keyframe.
    if not limits[0] < limits[1]:
        return None
    unit = math.pi / 180.0 if degrees and attributes.get("type", "hinge") == "hinge" else 1.0
    return limits[0] * unit, limits[1] * unit
