"""URDF: the tree of links and joints.

Element rules are those of urdfdom's 1.0 format. A link's frame is its joint's; `rpy` is extrinsic
xyz. `unsupported` reports what is lost.
"""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from linkwright.stages.export.paints import Paint, materials, paint
from linkwright.stages.export.urdf.form import package_of
from linkwright.stages.export.urdf.lowering import LoweredJoint, lower
from linkwright.stages.export.urdf.section import UrdfFormatSection
from linkwright.stages.formats.numbers import LENGTH, TURN, number, numbers, spaced
from linkwright.stages.formats.urdf.names import UrdfNames
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Element, element, parse, to_bytes
from linkwright.stages.robot.dynamics.inertia import SPECK, ZERO
from linkwright.stages.robot.model.geometry import Geometry, Role, Shape
from linkwright.stages.robot.model.poses import from_parts, rpy_from_rotation
from linkwright.stages.robot.model.robot import Array, Inertial, Limits, Primitive, Robot

UNSET_EFFORT = 100.0
UNSET_VELOCITY = 10.0
UNSET_REACH = {"revolute": 2 * math.pi, "prismatic": 1.0}
"""Defaults of limits that are not set [rad, m]: URDF requires a number."""


def write_urdf(written: Written, keys: UrdfFormatSection | None = None) -> bytes:
    """The robot as URDF, with paths and inertials as `keys` choose."""
    keys = keys or UrdfFormatSection()
    robot, held, geometry = written.as_urdf.robot, written.as_urdf.held, written.shapes
    assets = _assets_of(keys, robot.name)
    massless = SPECK if keys.frame_inertia == "tiny" else ZERO
    root = element(None, "robot", name=robot.name)
    # MuJoCo would strip the mesh paths, fuse a fixed root away and drop the visuals.
    mujoco = element(root, "mujoco")
    element(mujoco, "compiler", strippath="false", fusestatic="false", discardvisual="false")
    painted = _materials(root, geometry, assets)
    solid = {held[shape.link][0] for shape in geometry.shapes}
    shapes = geometry.by_link()
    on: dict[str, list[str]] = {}
    for name, (holder, _) in held.items():
        on.setdefault(holder, []).append(name)
    for link in robot.links:
        # A root called `world` is nothing, which no engine weighs.
        weightless = link.inertial.mass == 0 and link.name != "world"
        inertial = massless if weightless else link.inertial
        node = _link(root, link.name, inertial, link.name in solid)
        _shapes(node, [(name, held[name][1]) for name in on[link.name]], shapes, painted, assets)
    lowered = lower(robot)
    for item in lowered:
        for name in item.between:
            _link(root, name, SPECK, False)
    relations = {relation.follower: relation for relation in robot.relations}
    for joint in (joint for item in lowered for joint in item.joints):
        node = _joint(root, joint)
        relation = relations.get(joint.name)
        if relation is not None:
            offset = number(relation.offset, least=LENGTH if joint.type == "prismatic" else TURN)
            element(
                node,
                "mimic",
                joint=relation.driver,
                multiplier=number(relation.multiplier),
                offset=None if offset == "0" else offset,
            )
    _frames(root, robot, written.urdf_names, massless)
    for text in robot.controls:
        root.append(parse(text.encode()))
    return to_bytes(root)


def _origin(parent: Element, pose: Array) -> None:
    rpy = rpy_from_rotation(pose[:3, :3])
    element(parent, "origin", xyz=spaced(pose[:3, 3], least=LENGTH), rpy=spaced(rpy, least=TURN))


def _assets_of(keys: UrdfFormatSection, robot: str) -> str:
    """What the path of a mesh in a URDF begins with, for a robot of this name."""
    package = package_of(keys, robot)
    return f"package://{package}/assets/" if package else "assets/"


def _materials(root: Element, geometry: Geometry, assets: str) -> dict[Paint, str]:
    names = materials(geometry)
    for (colour, texture), name in names.items():
        node = element(root, "material", name=name)
        element(node, "color", rgba=spaced(colour))
        if texture:
            element(node, "texture", filename=f"{assets}{texture}")
    return names


def _link(root: Element, name: str, body: Inertial, shaped: bool) -> Element:
    node = element(root, "link", name=name)
    # MuJoCo would derive the mass of a link without an inertial from its shapes.
    if body.mass > 0 or shaped:
        inertial = element(node, "inertial")
        element(inertial, "origin", xyz=spaced(body.com, least=LENGTH), rpy="0 0 0")
        element(inertial, "mass", value=number(body.mass))
        texts = numbers(body.inertia)
        keys = {"ixx": 0, "ixy": 1, "ixz": 2, "iyy": 4, "iyz": 5, "izz": 8}
        element(inertial, "inertia", **{key: texts[index] for key, index in keys.items()})
    return node


def _shapes(
    node: Element,
    links: Sequence[tuple[str, Array]],
    shapes: Mapping[tuple[str, Role], Sequence[Shape]],
    painted: Mapping[Paint, str],
    assets: str,
) -> None:
    """The shapes of `links` at their places (4, 4) in the link of `node`."""
    roles: tuple[Role, ...] = ("visual", "collision")
    for role in roles:
        for place, shape in ((at, one) for link, at in links for one in shapes[link, role]):
            for pose, tag, attributes in _solids(shape, assets):
                holder = element(node, role)
                _origin(holder, place @ pose)
                element(element(holder, "geometry"), tag, **attributes)
                own = paint(shape)
                if own is not None:
                    element(holder, "material", name=painted[own])


def _solids(shape: Shape, assets: str) -> Iterator[tuple[Array, str, dict[str, str]]]:
    """The URDF geometries of a shape: link_from_solid (4, 4), element, attributes."""
    if shape.primitive is None:
        yield np.eye(4), "mesh", {"filename": f"{assets}{shape.file}"}
    else:
        yield from _primitive(shape.primitive)


def _primitive(primitive: Primitive) -> Iterator[tuple[Array, str, dict[str, str]]]:
    pose, size = primitive.link_from_shape, primitive.size
    if primitive.kind == "box":
        yield pose, "box", {"size": spaced(size)}
        return
    radius = {"radius": number(size[0])}
    if primitive.kind == "sphere":
        yield pose, "sphere", radius
        return
    yield pose, "cylinder", {**radius, "length": number(size[1])}
    if primitive.kind == "capsule":
        # URDF has no capsule: a ball at either end makes one.
        for end in (-size[1] / 2, size[1] / 2):
            yield pose @ from_parts(np.eye(3), np.array([0.0, 0.0, end])), "sphere", radius


def _joint(root: Element, joint: LoweredJoint) -> Element:
    node = element(root, "joint", name=joint.name, type=joint.type)
    _origin(node, joint.parent_from_joint)
    element(node, "parent", link=joint.parent)
    element(node, "child", link=joint.child)
    if joint.axis is None:
        return node
    limits, dynamics = joint.limits, joint.dynamics
    element(node, "axis", xyz=spaced(joint.axis))
    low, high = (None, None) if joint.type == "continuous" else _ends(joint.type, limits)
    element(
        node,
        "limit",
        lower=low,
        upper=high,
        effort=number(UNSET_EFFORT if dynamics.effort is None else dynamics.effort),
        velocity=number(UNSET_VELOCITY if dynamics.velocity is None else dynamics.velocity),
    )
    if dynamics.damping is not None or dynamics.friction is not None:
        element(
            node,
            "dynamics",
            damping=number(dynamics.damping or 0.0),
            friction=number(dynamics.friction or 0.0),
        )
    return node


def _ends(kind: str, limits: Limits) -> list[str]:
    """The texts of both ends of the range."""
    return numbers(_range(kind, limits), least=LENGTH if kind == "prismatic" else TURN)


def _range(kind: str, limits: Limits) -> tuple[float, float]:
    """Both ends of the range; an open one lies a fixed reach away, beyond zero and the other end."""
    reach = UNSET_REACH[kind]
    low, high = limits.lower, limits.upper
    if low is None:
        low = -reach if high is None else min(-reach, high - reach)
    if high is None:
        high = max(reach, low + reach)
    return low, high


def _frames(root: Element, robot: Robot, names: UrdfNames, massless: Inertial) -> None:
    """Frames, and both sides of every loop, as links on fixed joints with the inertial `massless`."""
    markers = [(names.frames[frame.name], frame.link, frame.link_from_frame) for frame in robot.frames]
    for loop in robot.loops:
        first, second = names.ends[loop.name]
        markers.append((first, loop.link_a, loop.a_from_frame))
        markers.append((second, loop.link_b, loop.b_from_frame))
    for name, parent, pose in markers:
        _link(root, name, massless, False)
        node = element(root, "joint", name=names.holders[name], type="fixed")
        _origin(node, pose)
        element(node, "parent", link=parent)
        element(node, "child", link=name)
