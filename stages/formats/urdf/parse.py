"""Reads URDF text: all of URDF 1.0, and what later readers add to it (capsules, ros2_control, ...).

What the file leaves out is as in ROS: no origin is the identity, no axis is x, a mimic has multiplier 1
and offset 0, and of several elements where one belongs the first counts.
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
_X = (1.0, 0.0, 0.0)
_MOST_ELEMENTS = 100_000


def parse(text: bytes, where: str) -> Urdf:
    """The robot in a URDF. `where` names the file in messages.

    SourceError where the text is no XML or no robot; everything else that is wrong with it is in
    `Urdf.diagnostics`.
    """
    root = _robot(text, where)
    log = FileDiagnostics(where)
    log.check(root, _PARTS, ("name", "version"))
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
    _report_doubles("link", links, log)
    _report_doubles("joint", joints, log)
    _report_textures(links, log, root)
    if not links:
        log.report("E-URDF-EMPTY", root, "the robot has no link")
    name = root.get("name", "")
    return Urdf(name, tuple(links), tuple(joints), tuple(drives), tuple(controls), log.collected())


def _leave_settings(element: Element, log: FileDiagnostics) -> None:
    """MuJoCo's own settings are left out, but for those of files and of what it would take away."""
    for one in element:
        if tag(one) != "compiler":
            log.leave_out(f"<{tag(one)}> of <mujoco>")
            continue
        for name in one.attrib:
            if name not in ("meshdir", "strippath", "fusestatic", "discardvisual"):
                log.leave_out(f"{name} of <compiler>")


def _robot(text: bytes, where: str) -> Element:
    try:
        root = xml.parse(text)
    except xml.Malformed as error:
        msg = f"not readable as a URDF: {error}"
        raise SourceError(msg, where, "give a URDF, or a xacro file that ends in .xacro") from None
    name = tag(root)
    if name != "robot":
        known = {"mujoco": "an MJCF: source=mjcf reads it", "sdf": "an SDF: convert it to a URDF first"}
        msg = f"not readable as a URDF: it starts with <{name}>, expected <robot>"
        raise SourceError(msg, where, f"it is {known[name]}" if name in known else "give a URDF")
    if len(root) > _MOST_ELEMENTS:
        msg = f"not readable as a URDF: it has {len(root)} elements, more than {_MOST_ELEMENTS}"
        raise SourceError(msg, where, "check that source.path names the right file")
    return root


def _link(element: Element, materials: Materials, log: FileDiagnostics) -> UrdfLink:
    log.check(element, ("inertial", "visual", "collision"), ("name", "type"))
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
    """The inertial in the link's frame: mass and tensor 0 where they are missing (W-URDF-INERTIAL)."""
    log.check(element, ("origin", "mass", "inertia"))
    mass, tensor = child(element, "mass", log), child(element, "inertia", log)
    lacking = [f"<{name}>" for name, one in (("mass", mass), ("inertia", tensor)) if one is None]
    if lacking:
        log.report("W-URDF-INERTIAL", element, f"<inertial> has no {' and no '.join(lacking)}, taken as 0")
    if mass is not None:
        log.check(mass, (), ("value",))
    link_from_inertial = pose(element, log)
    found = Inertial(_required(mass, "value", log), frozen(np.zeros(3)), frozen(_tensor(tensor, log)))
    return moved(found, link_from_inertial)


def _tensor(element: Element | None, log: FileDiagnostics) -> Array:
    xx, xy, xz, yy, yz, zz = (_required(element, name, log) for name in _MOMENTS)
    if element is not None:
        log.check(element, (), _MOMENTS)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def _required(element: Element | None, name: str, log: FileDiagnostics) -> float:
    """The number in an attribute that must be there; 0 where it is not (E-URDF-NUMBER)."""
    if element is None:
        return 0.0
    if not element.get(name, "").strip():
        log.report("E-URDF-NUMBER", element, f'<{tag(element)}> needs {name}="…"')
    return number(element, name, log, 0.0) or 0.0


def _joint(element: Element, log: FileDiagnostics) -> UrdfJoint | None:
    """A joint; None where it has no known type (E-URDF-TYPE) or no link (E-URDF-JOINT)."""
    log.check(
        element,
        ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
        ("name", "type", "dont_collapse"),
    )
    name, kind = _name(element, log), element.get("type", "")
    parent, below = _linked(element, "parent", log), _linked(element, "child", log)
    if kind not in _TYPES:
        wrong = f'has the type "{kind}"' if kind else "has no type"
        log.report("E-URDF-TYPE", element, f'joint "{name}" {wrong}', f"the types are {', '.join(_TYPES)}")
        return None
    joint_type: UrdfJointType = next(one for one in get_args(UrdfJointType) if one == kind)
    limits, effort, velocity = _limit(element, joint_type, log)
    dynamics = child(element, "dynamics", log)
    if dynamics is not None:
        log.check(dynamics, (), ("damping", "friction", *_ARMATURES))
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
"""What readers of <dynamics> call the inertia of a rotor as its joint feels it."""


def _linked(element: Element, role: str, log: FileDiagnostics) -> str:
    one = child(element, role, log)
    link: str = "" if one is None else one.get("link", "")
    if one is not None:
        log.check(one, (), ("link",))
    if not link.strip():
        name = element.get("name", "")
        log.report("E-URDF-JOINT", element, f'joint "{name}" needs <{role} link="…"/>')
        return ""
    return link


def _axis(element: Element, kind: UrdfJointType, log: FileDiagnostics) -> Array:
    axis = child(element, "axis", log)
    found = None
    if axis is not None:
        log.check(axis, (), ("xyz",))
        found = numbers(axis, "xyz", 3, log)
    vector = np.array(found or _X)
    largest = float(np.abs(vector).max())
    if largest == 0.0:
        if kind not in ("fixed", "floating"):
            log.report(
                "E-URDF-AXIS",
                axis,
                f'joint "{element.get("name", "")}" has the axis 0 0 0: it has no direction',
            )
        return frozen(_X)
    vector = vector / largest  # so that no square overflows or vanishes
    return frozen(vector / np.linalg.norm(vector))


def _limit(
    element: Element, kind: UrdfJointType, log: FileDiagnostics
) -> tuple[Limits | None, float | None, float | None]:
    """The range, effort and velocity; an infinite one counts as no limit."""
    limit = child(element, "limit", log)
    if limit is None:
        return None, None, None
    log.check(limit, (), ("lower", "upper", "effort", "velocity"))
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
    return value + 0.0 if np.isfinite(value) else None


def _size(element: Element, name: str, log: FileDiagnostics) -> float | None:
    """A largest effort or velocity, without its sign; None where there is none."""
    value = number(element, name, log, infinite=True)
    return None if value is None else _bound(abs(value))


def _resistance(element: Element | None, name: str, log: FileDiagnostics) -> float | None:
    value = None if element is None else number(element, name, log)
    if value is not None and value < 0:
        log.report("E-URDF-NUMBER", element, f'<dynamics {name}="{value:g}">: must not be negative')
        return None
    return value


def _mimic(element: Element, log: FileDiagnostics) -> UrdfMimic | None:
    mimic = child(element, "mimic", log)
    if mimic is None:
        return None
    log.check(mimic, (), ("joint", "multiplier", "offset"))
    followed: str = mimic.get("joint", "")
    if not followed.strip():
        log.report("E-URDF-MIMIC", mimic, f'joint "{element.get("name", "")}": <mimic> needs joint="…"')
        return None
    multiplier = number(mimic, "multiplier", log, 1.0)
    offset = number(mimic, "offset", log, 0.0)
    return UrdfMimic(followed, 1.0 if multiplier is None else multiplier, offset or 0.0)


def _report_doubles(what: str, found: Iterable[UrdfLink | UrdfJoint], log: FileDiagnostics) -> None:
    first: dict[str, int] = {}
    for one in found:
        if not one.name.strip():
            continue
        line = first.setdefault(one.name, one.line)
        if line != one.line:
            msg = f'another {what} is called "{one.name}" too, in line {line}'
            log.report("E-URDF-NAME", one.line, msg, "give each a name of its own")


def _report_textures(links: Iterable[UrdfLink], log: FileDiagnostics, root: Element) -> None:
    """I-URDF-TEXTURE for the images of primitives: they have no texture coordinates."""
    shapes = [shape for link in links for shape in link.visuals if shape.kind != "mesh"]
    names = {shape.texture for shape in shapes if shape.texture}
    if names:
        shown = ", ".join(sorted(names)[:5]) + (" ..." if len(names) > 5 else "")
        log.report(
            "I-URDF-TEXTURE", root, f"images of primitives are not carried over, only colours: {shown}"
        )
