"""Reads URDF text: all of URDF 1.0, and what later readers add to it (capsules, ros2_control, ...).

Defaults are those of ROS: no origin is the identity, no axis is x, a mimic has multiplier 1 and offset 0, and
of several elements where only one is allowed, the first counts.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import get_args

import numpy as np

from linkwright.stages.formats import xml
from linkwright.stages.formats.urdf.diagnostics import FileDiagnostics
from linkwright.stages.formats.urdf.elements import child, number, numbers, pose
from linkwright.stages.formats.urdf.model import (
    Transmission,
    Urdf,
    UrdfJoint,
    UrdfJointType,
    UrdfLink,
    UrdfMimic,
)
from linkwright.stages.formats.urdf.shapes import Materials, collisions, visuals
from linkwright.stages.formats.urdf.transmissions import controlled, rotors, transmissions
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.dynamics.inertia import moved
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.model.robot import Array, Inertial, Limits, frozen

_TYPES: tuple[str, ...] = get_args(UrdfJointType)
_PARTS = ("link", "joint", "material", "transmission", "ros2_control", "mujoco")
_DEFAULT_AXIS = (1.0, 0.0, 0.0)
"""The axis of a joint without an <axis>."""

_MAX_ELEMENTS = 100_000
"""Largest number of elements directly below the root of a URDF."""


def parse(text: bytes, where: str) -> Urdf:
    """Returns the robot in a URDF. `where` names the file in messages.

    Raises SourceError if the text is not XML or not a robot; everything else that is wrong with it is in
    `Urdf.diagnostics`.
    """
    root = _robot(text, where)
    log = FileDiagnostics(where)
    log.count_left_out(root, _PARTS, ("name", "version"))
    materials = Materials(root, log)
    links, joints, drives = list[UrdfLink](), list[UrdfJoint](), list[Transmission]()
    controls, armatures = list[str](), dict[str, float]()
    for element in root:
        name = tag(element)
        if name in ("transmission", "ros2_control"):
            controls.append(xml.to_text(element))
        if name == "link":
            links.append(_link(element, materials, log))
        elif name == "joint":
            joint = _joint(element, log)
            joints += [joint] if joint else []
        elif name == "transmission":
            drives += transmissions(element, log)
            armatures |= rotors(element, log)
        elif name == "ros2_control":
            drives += controlled(element, log)
        elif name == "mujoco":
            _leave_settings(element, log)
    joints = [
        replace(joint, armature=armatures.get(joint.name)) if joint.armature is None else joint
        for joint in joints
    ]
    _report_repeated_names("link", links, log)
    _report_repeated_names("joint", joints, log)
    _report_textures(links, log, root)
    if not links:
        log.report("E-URDF-EMPTY", root, "the robot has no link")
    name = root.get("name", "")
    return Urdf(name, tuple(links), tuple(joints), tuple(drives), tuple(controls), log.collected())


def _leave_settings(element: Element, log: FileDiagnostics) -> None:
    """Reports MuJoCo's own settings, which are left out, except the settings of files and of parts that
    MuJoCo removes."""
    for setting in element:
        if tag(setting) != "compiler":
            log.leave_out(f"<{tag(setting)}> of <mujoco>")
            continue
        for name in setting.attrib:
            if name not in ("meshdir", "strippath", "fusestatic", "discardvisual"):
                log.leave_out(f"{name} of <compiler>")


def _robot(text: bytes, where: str) -> Element:
    """Returns the root element of a URDF. Raises SourceError for other texts and for too many elements."""
    try:
        root = xml.parse(text)
    except xml.Malformed as error:
        msg = f"not readable as a URDF: {error}"
        raise SourceError(msg, where, "give a URDF, or a xacro file that ends in .xacro") from None
    name = tag(root)
    if name != "robot":
        formats = {"mujoco": "an MJCF: source=mjcf reads it", "sdf": "an SDF: convert it to a URDF first"}
        msg = f"not readable as a URDF: it starts with <{name}>, expected <robot>"
        raise SourceError(msg, where, f"it is {formats[name]}" if name in formats else "give a URDF")
    if len(root) > _MAX_ELEMENTS:
        msg = f"not readable as a URDF: it has {len(root)} elements, more than {_MAX_ELEMENTS}"
        raise SourceError(msg, where, "check that source.path names the right file")
    return root


def _link(element: Element, materials: Materials, log: FileDiagnostics) -> UrdfLink:
    log.count_left_out(element, ("inertial", "visual", "collision"), ("name", "type"))
    inertial = child(element, "inertial", log)
    return UrdfLink(
        name=_name(element, log),
        inertial=None if inertial is None else _inertial(inertial, log),
        visuals=visuals(element, materials, log),
        collisions=collisions(element, log),
        line=element.sourceline,
    )


def _name(element: Element, log: FileDiagnostics) -> str:
    name: str = element.get("name", "")
    if not name.strip():
        log.report("E-URDF-NAME", element, f"a <{tag(element)}> has no name")
    return name


def _inertial(element: Element, log: FileDiagnostics) -> Inertial:
    """Returns the inertial in the link's frame: mass and tensor are 0 if they are missing (reports
    W-URDF-INERTIAL)."""
    log.count_left_out(element, ("origin", "mass", "inertia"))
    mass, tensor = child(element, "mass", log), child(element, "inertia", log)
    lacking = [f"<{name}>" for name, node in (("mass", mass), ("inertia", tensor)) if node is None]
    if lacking:
        log.report("W-URDF-INERTIAL", element, f"<inertial> has no {' and no '.join(lacking)}, taken as 0")
    if mass is not None:
        log.count_left_out(mass, (), ("value",))
    link_from_inertial = pose(element, log)
    inertial = Inertial(_required(mass, "value", log), frozen(np.zeros(3)), frozen(_tensor(tensor, log)))
    return moved(inertial, link_from_inertial)


def _tensor(element: Element | None, log: FileDiagnostics) -> Array:
    xx, xy, xz, yy, yz, zz = (_required(element, name, log) for name in _MOMENTS)
    if element is not None:
        log.count_left_out(element, (), _MOMENTS)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def _required(element: Element | None, name: str, log: FileDiagnostics) -> float:
    """Returns the number in an attribute; 0 without it (reports E-URDF-NUMBER), or without the element."""
    if element is None:
        return 0.0
    if not element.get(name, "").strip():
        log.report("E-URDF-NUMBER", element, f'<{tag(element)}> needs {name}="…"')
    return number(element, name, log, 0.0) or 0.0


def _joint(element: Element, log: FileDiagnostics) -> UrdfJoint | None:
    """Returns a joint; None if it has no known type (reports E-URDF-TYPE) or no link (E-URDF-JOINT)."""
    log.count_left_out(
        element,
        ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
        ("name", "type", "dont_collapse"),
    )
    name, kind = _name(element, log), element.get("type", "")
    parent, below = _linked(element, "parent", log), _linked(element, "child", log)
    if kind not in _TYPES:
        fault = f'has the type "{kind}"' if kind else "has no type"
        log.report("E-URDF-TYPE", element, f'joint "{name}" {fault}', f"the types are {', '.join(_TYPES)}")
        return None
    joint_type: UrdfJointType = next(name for name in get_args(UrdfJointType) if name == kind)
    limits, effort, velocity = _limit(element, joint_type, log)
    dynamics = child(element, "dynamics", log)
    if dynamics is not None:
        log.count_left_out(dynamics, (), ("damping", "friction", *_ARMATURES))
    armatures = [_resistance(dynamics, name, log) for name in _ARMATURES]
    joint = UrdfJoint(
        name=name,
        type=joint_type,
        parent=parent,
        child=below,
        parent_from_joint=pose(element, log),
        axis=_axis(element, joint_type, log),
        limits=limits,
        effort=effort,
        velocity=velocity,
        damping=_resistance(dynamics, "damping", log),
        friction=_resistance(dynamics, "friction", log),
        armature=next((value for value in armatures if value is not None), None),
        mimic=_mimic(element, log),
        line=element.sourceline,
    )
    return joint if parent and below else None


_ARMATURES = ("rotorInertia", "rotor_inertia", "armature")
"""The names of a rotor's inertia at its joint in <dynamics>, by reader."""


def _linked(element: Element, role: str, log: FileDiagnostics) -> str:
    """Returns the link that is a joint's parent or child; "" without it (reports E-URDF-JOINT)."""
    end = child(element, role, log)
    link: str = "" if end is None else end.get("link", "")
    if end is not None:
        log.count_left_out(end, (), ("link",))
    if not link.strip():
        name = element.get("name", "")
        log.report("E-URDF-JOINT", element, f'joint "{name}" needs <{role} link="…"/>')
        return ""
    return link


def _axis(element: Element, kind: UrdfJointType, log: FileDiagnostics) -> Array:
    """Returns the unit vector (3,) of a joint's axis: x if it is missing, or 0 0 0 (reports E-URDF-AXIS)."""
    axis = child(element, "axis", log)
    direction = None
    if axis is not None:
        log.count_left_out(axis, (), ("xyz",))
        direction = numbers(axis, "xyz", 3, log)
    vector = np.array(direction or _DEFAULT_AXIS)
    largest = float(np.abs(vector).max())
    if largest == 0.0:
        if kind not in ("fixed", "floating"):
            msg = f'joint "{element.get("name", "")}" has the axis 0 0 0: it has no direction'
            log.report("E-URDF-AXIS", axis, msg)
        return frozen(_DEFAULT_AXIS)
    vector = vector / largest  # so that no square overflows or vanishes
    return frozen(vector / np.linalg.norm(vector))


def _limit(
    element: Element, kind: UrdfJointType, log: FileDiagnostics
) -> tuple[Limits | None, float | None, float | None]:
    """Returns the range, effort and velocity; an infinite value counts as no limit."""
    limit = child(element, "limit", log)
    if limit is None:
        return None, None, None
    log.count_left_out(limit, (), ("lower", "upper", "effort", "velocity"))
    effort, velocity = _size(limit, "effort", log), _size(limit, "velocity", log)
    lower = number(limit, "lower", log, 0.0, infinite=True) or 0.0
    upper = number(limit, "upper", log, 0.0, infinite=True) or 0.0
    if kind not in ("revolute", "prismatic"):
        return None, effort, velocity
    if lower > upper:
        msg = (
            f'joint "{element.get("name", "")}": its lower limit {lower:g} is above its upper limit {upper:g}'
        )
        log.report("E-URDF-LIMIT", limit, msg)
    return Limits(_bound(lower), _bound(upper)), effort, velocity


def _bound(value: float) -> float | None:
    # + 0.0 makes −0 a 0.
    return value + 0.0 if np.isfinite(value) else None


def _size(element: Element, name: str, log: FileDiagnostics) -> float | None:
    """Returns a largest effort or velocity, without its sign; None if it is missing or infinite."""
    value = number(element, name, log, infinite=True)
    return None if value is None else _bound(abs(value))


def _resistance(element: Element | None, name: str, log: FileDiagnostics) -> float | None:
    """Returns a number in a <dynamics>; None if it is missing or negative (reports E-URDF-NUMBER)."""
    value = None if element is None else number(element, name, log)
    if value is not None and value < 0:
        log.report("E-URDF-NUMBER", element, f'<dynamics {name}="{value:g}">: must not be negative')
        return None
    return value


def _mimic(element: Element, log: FileDiagnostics) -> UrdfMimic | None:
    """Returns a joint's <mimic>; None without it, or if it names no joint (reports E-URDF-MIMIC)."""
    mimic = child(element, "mimic", log)
    if mimic is None:
        return None
    log.count_left_out(mimic, (), ("joint", "multiplier", "offset"))
    followed: str = mimic.get("joint", "")
    if not followed.strip():
        log.report("E-URDF-MIMIC", mimic, f'joint "{element.get("name", "")}": <mimic> needs joint="…"')
        return None
    multiplier = number(mimic, "multiplier", log, 1.0)
    offset = number(mimic, "offset", log, 0.0)
    return UrdfMimic(followed, 1.0 if multiplier is None else multiplier, offset or 0.0)


def _report_repeated_names(kind: str, items: Iterable[UrdfLink | UrdfJoint], log: FileDiagnostics) -> None:
    """Reports E-URDF-NAME for each item with the name of an earlier item; missing names are reported
    already."""
    first_line_by_name: dict[str, int] = {}
    for item in items:
        if item.name in first_line_by_name:
            msg = f'another {kind} is called "{item.name}" too, in line {first_line_by_name[item.name]}'
            log.report("E-URDF-NAME", item.line, msg, "give each a name of its own")
        elif item.name.strip():
            first_line_by_name[item.name] = item.line


def _report_textures(links: Iterable[UrdfLink], log: FileDiagnostics, root: Element) -> None:
    """Reports I-URDF-TEXTURE for the images of primitives: they have no texture coordinates."""
    shapes = [shape for link in links for shape in link.visuals if shape.kind != "mesh"]
    names = {shape.texture for shape in shapes if shape.texture}
    if names:
        name_list = ", ".join(sorted(names)[:5]) + (" ..." if len(names) > 5 else "")
        log.report(
            "I-URDF-TEXTURE", root, f"images of primitives are not carried over, only colours: {name_list}"
        )
