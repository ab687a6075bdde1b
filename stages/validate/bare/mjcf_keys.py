"""Checks the keyframes of an MJCF: the number of their values, and that positions are within limits."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from linkwright.stages.formats.mjcf.controls import control_count
from linkwright.stages.formats.xml import Element
from linkwright.stages.validate.bare.findings import CodedFinding, parse_numbers
from linkwright.stages.validate.bare.mjcf_defaults import Defaults
from linkwright.stages.validate.bare.mjcf_values import degrees_of
from linkwright.stages.validate.reading.documents import MAKERS, ModelDocument

_QPOS_COUNTS = {"hinge": 1, "slide": 1, "ball": 4, "free": 7}
"""Type of a joint → the number of its values in qpos."""

_QVEL_COUNTS = {"hinge": 1, "slide": 1, "ball": 3, "free": 6}
"""Type of a joint → the number of its values in qvel."""

_MIN_QUATERNION_LENGTH = 1e-10
"""Length below which a quaternion has no direction."""

UNIT_LENGTH_TOLERANCE = 1e-2
"""Largest difference between the length of a quaternion and 1."""

RANGE_TOLERANCE = 1e-3
"""Largest distance [rad, m] of a coordinate beyond its range: files have few digits."""


@dataclass(frozen=True, slots=True, eq=False)
class _Joint:
    """A joint of the model."""

    name: str
    """The name; the type for a joint without a name."""

    type: str
    """The type, a key of `_QPOS_COUNTS`."""

    qpos_index: int
    """The index of the joint's first value in qpos."""

    limits: tuple[float, float] | None
    """The range [rad, m]; None for a joint without limits."""


def check(document: ModelDocument) -> Iterator[CodedFinding]:
    """Checks the number of values in qpos, qvel and ctrl, the length of the quaternions in qpos, and that
    joints are within their limits.

    Files with elements that make other elements are skipped, since the joints that they make are not in the
    text. Keyframes from included files are skipped, too.
    """
    keyframes = [key for key in document.root.iterfind("keyframe/key") if key not in document.included]
    if not keyframes or any(element.tag in MAKERS for element in document.root.iter()):
        return
    defaults = Defaults(document.root)
    joints = list(_joints(document, defaults))
    counts = {
        "qpos": sum(_QPOS_COUNTS[joint.type] for joint in joints),
        "qvel": sum(_QVEL_COUNTS[joint.type] for joint in joints),
        "ctrl": sum(
            control_count(str(actuator.tag), defaults.attributes(actuator).get("input"))
            for actuator in document.root.iterfind("actuator/*")
        ),
    }
    for keyframe in keyframes:
        for attribute, expected_count in counts.items():
            values = parse_numbers(keyframe.get(attribute))
            if values is not None and len(values) != expected_count:
                message = f"it has {len(values)} numbers, but the model needs {expected_count}"
                yield "C-KEYS", document.finding(keyframe, attribute, message)
            elif values is not None and attribute == "qpos":
                yield from _check_qpos(document, keyframe, values, joints)


def _check_qpos(
    document: ModelDocument, keyframe: Element, qpos: Sequence[float], joints: Sequence[_Joint]
) -> Iterator[CodedFinding]:
    """Checks that quaternions have unit length, and that joints are within their limits. `qpos` must have the
    right number of values."""
    for joint in joints:
        if joint.type in ("ball", "free"):
            # The position of a free joint precedes its quaternion.
            quaternion_index = joint.qpos_index + (3 if joint.type == "free" else 0)
            length = math.hypot(*qpos[quaternion_index : quaternion_index + 4])
            if abs(length - 1.0) > UNIT_LENGTH_TOLERANCE:
                message = f'the quaternion of "{joint.name}" has the length {length:.4g}, expected 1'
                # MuJoCo normalises quaternions, but a quaternion of length 0 has no direction.
                code = "C-KEYS" if length < _MIN_QUATERNION_LENGTH else "C-PLAUSIBLE"
                yield code, document.finding(keyframe, "qpos", message)
        elif joint.limits is not None:
            value, (low, high) = qpos[joint.qpos_index], joint.limits
            if not low - RANGE_TOLERANCE <= value <= high + RANGE_TOLERANCE:
                message = f'"{joint.name}" is at {value:g}, outside its range {low:g} to {high:g}'
                yield "C-PLAUSIBLE", document.finding(keyframe, "qpos", message)


def _joints(document: ModelDocument, defaults: Defaults) -> Iterator[_Joint]:
    """Yields the joints in the order of their values in qpos. A joint of an unknown type is left out: MuJoCo
    refuses the file."""
    uses_degrees = degrees_of(document)
    qpos_index = 0
    for element in document.root.iterfind("worldbody//*"):
        if element.tag not in ("joint", "freejoint"):
            continue
        attributes = defaults.attributes(element) if element.tag == "joint" else {"type": "free"}
        joint_type = attributes.get("type", "hinge")
        if joint_type not in _QPOS_COUNTS:
            continue
        limits = _limits(joint_type, attributes, uses_degrees) if joint_type in ("hinge", "slide") else None
        # Messages call an unnamed joint by its type.
        yield _Joint(str(element.get("name", joint_type)), joint_type, qpos_index, limits)
        qpos_index += _QPOS_COUNTS[joint_type]


def _limits(joint_type: str, attributes: Mapping[str, str], uses_degrees: bool) -> tuple[float, float] | None:
    """Returns the range [rad, m] of a hinge or slide; None if the joint has no range. `uses_degrees`: whether
    the file's angles are in degrees."""
    limits = parse_numbers(attributes.get("range"))
    if limits is None or len(limits) != 2 or attributes.get("limited", "auto") == "false":
        return None
    # An empty range is a fault of the joint, not of the keyframe.
    if not limits[0] < limits[1]:
        return None
    factor = math.pi / 180.0 if uses_degrees and joint_type == "hinge" else 1.0
    return limits[0] * factor, limits[1] * factor
