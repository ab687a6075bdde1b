"""Reads URDF text: all of URDF 1.0, and what later readers add to it (capsules, ros2_control, ...).

What the file leaves out is as in ROS: no origin is the identity, no axis is x, a mimic has multiplier 1
and offset 0, and of several elements where one belongs the first counts.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import get_args

import numpy as np

from stages.formats import xml
from stages.formats.urdf.elements import Told, child, number, numbers, pose, tag
from stages.formats.urdf.model import Transmission, Urdf, UrdfJoint, UrdfJointType, UrdfLink, UrdfMimic
from stages.formats.urdf.shapes import Materials, collisions, visuals
from stages.formats.urdf.transmissions import controlled, rotors, transmissions
from stages.formats.xml import Element
from stages.robot.errors import SourceError
from stages.robot.inertia import moved
from stages.robot.model import Array, Inertial, Limits, frozen

_TYPES: tuple[str, ...] = get_args(UrdfJointType)
_PARTS = ("link", "joint", "material", "transmission", "ros2_control", "mujoco")
_X = (1.0, 0.0, 0.0)
_MOST_ELEMENTS = 100_000


def parse(text: bytes, where: str) -> Urdf:
    """The robot in a URDF. `where` names the file in messages.

    SourceError where the text is no XML or no robot; all else that is wrong with it is told, at once,
    by `Urdf.diagnostics`.
    """
    root = _robot(text, where)
    told = Told(where)
    told.check(root, _PARTS, ("name", "version"))
    materials = Materials(root, told)
    links, joints, drives = list[UrdfLink](), list[UrdfJoint](), list[Transmission]()
    controls, armatures = list[str](), dict[str, float]()
    for element in root:
        name = tag(element)
        if name in ("transmission", "ros2_control"):
            controls.append(xml.to_text(element))
        if name == "link":
            links.append(_link(element, materials, told))
        elif name == "joint":
            joint = _joint(element, told)
            joints += [joint] if joint else []
        elif name == "transmission":
            drives += transmissions(element, told)
            armatures |= rotors(element, told)
        elif name == "ros2_control":
            drives += controlled(element, told)
        elif name == "mujoco":
            _leave_settings(element, told)
    joints = [
        replace(joint, armature=armatures.get(joint.name)) if joint.armature is None else joint
        for joint in joints
    ]
    _tell_doubles("link", links, told)
    _tell_doubles("joint", joints, told)
    _tell_textures(links, told, root)
    if not links:
        told.tell("E-URDF-EMPTY", root, "the robot has no link")
    name = root.get("name", "")
    return Urdf(name, tuple(links), tuple(joints), tuple(drives), tuple(controls), told.everything())


def _leave_settings(element: Element, told: Told) -> None:
    """MuJoCo's own settings are left out, but for those of files and of what it would take away."""
    for one in element:
        if tag(one) != "compiler":
            told.leave(f"<{tag(one)}> of <mujoco>")
            continue
        for name in one.attrib:
            if name not in ("meshdir", "strippath", "fusestatic", "discardvisual"):
                told.leave(f"{name} of <compiler>")


def _robot(text: bytes, where: str) -> Element:
    try:
        root = xml.parse(text)
    except xml.Malformed as error:
        msg = f"it is not readable as a URDF: {error}"
        raise SourceError(msg, where, "give a URDF, or a xacro file that ends in .xacro") from None
    name = tag(root)
    if name != "robot":
        known = {"mujoco": "an MJCF: source=mjcf reads it", "sdf": "an SDF: convert it to a URDF first"}
        msg = f"it is not readable as a URDF: it starts with <{name}>, and a URDF with <robot>"
        raise SourceError(msg, where, f"it is {known[name]}" if name in known else "give a URDF")
    if len(root) > _MOST_ELEMENTS:
        msg = f"it is not readable as a URDF: it has {len(root)} elements; at most {_MOST_ELEMENTS} are read"
        raise SourceError(msg, where, "check that source.path names the right file")
    return root


def _link(element: Element, materials: Materials, told: Told) -> UrdfLink:
    told.check(element, ("inertial", "visual", "collision"), ("name", "type"))
    inertial = child(element, "inertial", told)
    return UrdfLink(
        name=_name(element, told),
        inertial=None if inertial is None else _inertial(inertial, told),
        visuals=visuals(element, materials, told),
        collisions=collisions(element, told),
        line=element.sourceline,
    )


def _name(element: Element, told: Told) -> str:
    name: str = element.get("name", "")
    if not name.strip():
        told.tell("E-URDF-NAME", element, f"a <{tag(element)}> has no name")
    return name


def _inertial(element: Element, told: Told) -> Inertial:
    """The inertial in the link's frame: mass and tensor 0 where they are not given, which is told."""
    told.check(element, ("origin", "mass", "inertia"))
    mass, tensor = child(element, "mass", told), child(element, "inertia", told)
    lacking = [f"<{name}>" for name, one in (("mass", mass), ("inertia", tensor)) if one is None]
    if lacking:
        told.tell("W-URDF-INERTIAL", element, f"<inertial> has no {' and no '.join(lacking)}, taken as 0")
    if mass is not None:
        told.check(mass, (), ("value",))
    link_from_inertial = pose(element, told)
    found = Inertial(_required(mass, "value", told), frozen(np.zeros(3)), frozen(_tensor(tensor, told)))
    return moved(found, link_from_inertial)


def _tensor(element: Element | None, told: Told) -> Array:
    xx, xy, xz, yy, yz, zz = (_required(element, name, told) for name in _MOMENTS)
    if element is not None:
        told.check(element, (), _MOMENTS)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def _required(element: Element | None, name: str, told: Told) -> float:
    """The number in an attribute that must be there; 0 where it is not, which is told."""
    if element is None:
        return 0.0
    if not element.get(name, "").strip():
        told.tell("E-URDF-NUMBER", element, f'<{tag(element)}> needs {name}="…"')
    return number(element, name, told, 0.0) or 0.0


def _joint(element: Element, told: Told) -> UrdfJoint | None:
    """A joint; None where it has no type or no link, which is told."""
    told.check(
        element,
        ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
        ("name", "type", "dont_collapse"),
    )
    name, kind = _name(element, told), element.get("type", "")
    parent, below = _linked(element, "parent", told), _linked(element, "child", told)
    if kind not in _TYPES:
        said = f'has the type "{kind}"' if kind else "has no type"
        told.tell("E-URDF-TYPE", element, f'joint "{name}" {said}', f"the types are {', '.join(_TYPES)}")
        return None
    joint_type: UrdfJointType = next(one for one in get_args(UrdfJointType) if one == kind)
    limits, effort, velocity = _limit(element, joint_type, told)
    dynamics = child(element, "dynamics", told)
    if dynamics is not None:
        told.check(dynamics, (), ("damping", "friction", *_ARMATURES))
    armatures = [_resistance(dynamics, name, told) for name in _ARMATURES]
    joint = UrdfJoint(
        name=name,
        type=joint_type,
        parent=parent,
        child=below,
        parent_from_joint=pose(element, told),
        axis=_axis(element, joint_type, told),
        limits=limits,
        effort=effort,
        velocity=velocity,
        damping=_resistance(dynamics, "damping", told),
        friction=_resistance(dynamics, "friction", told),
        armature=next((value for value in armatures if value is not None), None),
        mimic=_mimic(element, told),
        line=element.sourceline,
    )
    return joint if parent and below else None


_ARMATURES = ("rotorInertia", "rotor_inertia", "armature")
"""What readers of <dynamics> call the inertia of a rotor as its joint feels it."""


def _linked(element: Element, role: str, told: Told) -> str:
    one = child(element, role, told)
    link: str = "" if one is None else one.get("link", "")
    if one is not None:
        told.check(one, (), ("link",))
    if not link.strip():
        name = element.get("name", "")
        told.tell("E-URDF-JOINT", element, f'joint "{name}" needs <{role} link="…"/>')
        return ""
    return link


def _axis(element: Element, kind: UrdfJointType, told: Told) -> Array:
    axis = child(element, "axis", told)
    found = None
    if axis is not None:
        told.check(axis, (), ("xyz",))
        found = numbers(axis, "xyz", 3, told)
    vector = np.array(found or _X)
    largest = float(np.abs(vector).max())
    if largest == 0.0:
        if kind not in ("fixed", "floating"):
            told.tell("E-URDF-AXIS", axis, f'joint "{element.get("name", "")}" moves about or along no axis')
        return frozen(_X)
    vector = vector / largest  # so that no square overflows or vanishes
    return frozen(vector / np.linalg.norm(vector))


def _limit(
    element: Element, kind: UrdfJointType, told: Told
) -> tuple[Limits | None, float | None, float | None]:
    """The range, effort and velocity; an infinite one is none."""
    limit = child(element, "limit", told)
    if limit is None:
        return None, None, None
    told.check(limit, (), ("lower", "upper", "effort", "velocity"))
    effort, velocity = _size(limit, "effort", told), _size(limit, "velocity", told)
    lower = number(limit, "lower", told, 0.0, infinite=True) or 0.0
    upper = number(limit, "upper", told, 0.0, infinite=True) or 0.0
    if kind not in ("revolute", "prismatic"):
        return None, effort, velocity
    if lower > upper:
        msg = (
            f'joint "{element.get("name", "")}": its lower limit {lower:g} is above its upper limit {upper:g}'
        )
        told.tell("E-URDF-LIMIT", limit, msg)
    return Limits(_bound(lower), _bound(upper)), effort, velocity


def _bound(value: float) -> float | None:
    return value + 0.0 if np.isfinite(value) else None


def _size(element: Element, name: str, told: Told) -> float | None:
    """A largest effort or velocity, without its sign; None where there is none."""
    value = number(element, name, told, infinite=True)
    return None if value is None else _bound(abs(value))


def _resistance(element: Element | None, name: str, told: Told) -> float | None:
    value = None if element is None else number(element, name, told)
    if value is not None and value < 0:
        told.tell("E-URDF-NUMBER", element, f'<dynamics {name}="{value:g}">: it cannot be negative')
        return None
    return value


def _mimic(element: Element, told: Told) -> UrdfMimic | None:
    mimic = child(element, "mimic", told)
    if mimic is None:
        return None
    told.check(mimic, (), ("joint", "multiplier", "offset"))
    followed: str = mimic.get("joint", "")
    if not followed.strip():
        told.tell(
            "E-URDF-MIMIC", mimic, f'joint "{element.get("name", "")}" mimics no joint: joint="…" lacks'
        )
        return None
    multiplier = number(mimic, "multiplier", told, 1.0)
    offset = number(mimic, "offset", told, 0.0)
    return UrdfMimic(followed, 1.0 if multiplier is None else multiplier, offset or 0.0)


def _tell_doubles(what: str, found: Iterable[UrdfLink | UrdfJoint], told: Told) -> None:
    first: dict[str, int] = {}
    for one in found:
        if not one.name.strip():
            continue
        line = first.setdefault(one.name, one.line)
        if line != one.line:
            msg = f'another {what} is called "{one.name}" too, in line {line}'
            told.tell("E-URDF-NAME", one.line, msg, "give each a name of its own")


def _tell_textures(links: Iterable[UrdfLink], told: Told, root: Element) -> None:
    names = {shape.texture for link in links for shape in link.visuals if shape.texture}
    if names:
        shown = ", ".join(sorted(names)[:5]) + (" ..." if len(names) > 5 else "")
        told.tell("I-URDF-TEXTURE", root, f"images are not carried over, only colours: {shown}")
