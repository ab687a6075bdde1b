"""SDF 1.9: the model of a robot, in one file.

Element rules are those of sdformat's 1.9 specification; `<mimic>` is that of 1.11: sdformat 12 takes it
as unknown in a file of 1.9, and reports errors for a file that says 1.11. A link stands in the frame of the
joint that carries it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.export.paints import paint
from linkwright.stages.export.sdf.contacts import SdfContacts
from linkwright.stages.export.sdf.lowering import SdfJoint, SdfJoints
from linkwright.stages.export.sdf.section import SdfFormatSection
from linkwright.stages.export.sdf.sensors import SdfSensor, Sensors, write_sensor
from linkwright.stages.formats.numbers import LENGTH, TURN, number, numbers, spaced
from linkwright.stages.formats.sdf.names import SdfNames
from linkwright.stages.formats.xml import Element, element, to_bytes
from linkwright.stages.robot.dynamics.inertia import SPECK
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.poses import rpy_from_rotation
from linkwright.stages.robot.model.robot import Array, Inertial, Primitive, Robot
from linkwright.stages.robot.text.names import free

VERSION = "1.9"
"""The newest that Gazebo Fortress and Debian 12 read."""


@dataclass(frozen=True, slots=True, eq=False)
class SdfPlan:
    """How a robot is said in SDF. `world_from_root` (4, 4): where the model stands."""

    names: SdfNames
    lowered: SdfJoints
    sensors: Sensors
    contacts: SdfContacts
    world_from_root: Array


def write_sdf(robot: Robot, geometry: Geometry, keys: SdfFormatSection, plan: SdfPlan) -> bytes:
    """The robot as SDF, with the paths of meshes as `keys` choose."""
    names, lowered = plan.names, plan.lowered
    root = element(None, "sdf", version=VERSION)
    first = names.links[robot.root.name]
    model = element(root, "model", name=robot.name, canonical_link=first)
    _pose(model, plan.world_from_root)
    if plan.contacts.collides:
        element(model, "self_collide").text = "true"
    assets = "assets/" if keys.meshes == "relative" else f"model://{robot.name}/assets/"
    carriers = {joint.child: joint for joint in lowered.joints if joint.carries}
    shapes = geometry.by_link()
    for link in robot.links:
        own = names.links[link.name]
        # SDF has no links without mass.
        body = link.inertial if link.inertial.mass > 0 else SPECK
        node = _link(model, own, body, carriers, lowered)
        taken: set[str] = set()
        _shapes(node, shapes[link.name, "visual"], "visual", assets, taken)
        colliders = _colliders(node, link.name, shapes[link.name, "collision"], assets, taken, plan)
        for one in plan.sensors.mounted:
            if one.link == link.name and not one.on_joint:
                _mounted(node, one, taken, colliders)
    for name in lowered.between:
        _link(model, name, SPECK, carriers, lowered)
    if robot.base.fixed:
        base = element(model, "joint", name=names.base, type="fixed")
        element(base, "parent").text = "world"
        element(base, "child").text = first
    loads: dict[str, list[SdfSensor]] = {}
    for one in plan.sensors.mounted:
        if one.on_joint:
            loads.setdefault(names.links[one.link], []).append(one)
    for joint in lowered.joints:
        made = _joint(model, joint)
        taken = set()
        for one in loads.get(joint.child, ()) if joint.carries else ():
            _mounted(made, one, taken, (), relative_to=joint.child)
    for frame in robot.frames:
        made = element(model, "frame", name=names.frames[frame.name], attached_to=names.links[frame.link])
        _pose(made, frame.link_from_frame)
    return to_bytes(root)


def write_config(robot: str) -> bytes:
    """`model.config`, by which Gazebo finds the SDF of a folder."""
    root = element(None, "model")
    element(root, "name").text = robot
    element(root, "version").text = "1.0"
    element(root, "sdf", version=VERSION).text = f"{robot}.sdf"
    element(root, "description").text = f"The robot {robot}"
    return to_bytes(root)


def _pose(above: Element, pose: Array, relative_to: str | None = None) -> None:
    place = spaced(pose[:3, 3], least=LENGTH)
    turned = spaced(rpy_from_rotation(pose[:3, :3]), least=TURN)
    element(above, "pose", relative_to=relative_to).text = f"{place} {turned}"


def _link(
    model: Element, name: str, body: Inertial, carriers: Mapping[str, SdfJoint], lowered: SdfJoints
) -> Element:
    node = element(model, "link", name=name)
    if name in carriers:
        _pose(node, np.eye(4), carriers[name].name)
    elif name in lowered.floating:
        above, pose = lowered.floating[name]
        _pose(node, pose, above)
    inertial = element(node, "inertial")
    element(inertial, "pose").text = f"{spaced(body.com, least=LENGTH)} 0 0 0"
    element(inertial, "mass").text = number(body.mass)
    tensor, texts = element(inertial, "inertia"), numbers(body.inertia)
    for key, index in (("ixx", 0), ("ixy", 1), ("ixz", 2), ("iyy", 4), ("iyz", 5), ("izz", 8)):
        element(tensor, key).text = texts[index]
    return node


def _mounted(
    above: Element, one: SdfSensor, taken: set[str], colliders: Sequence[str], relative_to: str | None = None
) -> None:
    """A sensor, whose name no sibling has."""
    name = free(one.name, taken)
    taken.add(name)
    node = write_sensor(above, one, name, colliders)
    _pose(node, one.link_from_sensor, relative_to)


def _shapes(node: Element, shapes: Sequence[Shape], tag: str, assets: str, taken: set[str]) -> list[Element]:
    """The elements of the shapes of one role."""
    made = []
    for count, shape in enumerate(shapes, 1):
        name = f"{tag}_{count}"
        taken.add(name)
        holder = element(node, tag, name=name)
        made.append(holder)
        _geometry(holder, shape, assets)
        if tag == "visual":
            _material(holder, shape)
    return made


def _colliders(
    node: Element, link: str, shapes: Sequence[Shape], assets: str, taken: set[str], plan: SdfPlan
) -> list[str]:
    """The colliders of a link, and their names."""
    names = []
    for count, (holder, shape) in enumerate(
        zip(_shapes(node, shapes, "collision", assets, taken), shapes, strict=True)
    ):
        _surface(holder, shape, plan.contacts.masks.get((link, count)))
        names.append(str(holder.get("name")))
    return names


def _surface(holder: Element, shape: Shape, mask: int | None) -> None:
    """The friction of a collider, and the bits of which it must share one with what it collides with."""
    friction = None if shape.contact is None else shape.contact.friction
    if friction is None and mask is None:
        return
    surface = element(holder, "surface")
    if friction is not None:
        ode = element(element(surface, "friction"), "ode")
        for key in ("mu", "mu2"):
            element(ode, key).text = number(friction[0])
    if mask is not None:
        element(element(surface, "contact"), "collide_bitmask").text = str(mask)


def _geometry(holder: Element, shape: Shape, assets: str) -> None:
    if shape.primitive is None:
        mesh = element(element(holder, "geometry"), "mesh")
        element(mesh, "uri").text = f"{assets}{shape.file}"
        return
    _pose(holder, shape.primitive.link_from_shape)
    _primitive(element(holder, "geometry"), shape.primitive)


def _primitive(above: Element, primitive: Primitive) -> None:
    node, size = element(above, primitive.kind), primitive.size
    if primitive.kind == "box":
        element(node, "size").text = spaced(size)
        return
    element(node, "radius").text = number(size[0])
    if primitive.kind != "sphere":
        element(node, "length").text = number(size[1])


def _material(holder: Element, shape: Shape) -> None:
    """The colour; a mesh with an image has a material of its own."""
    own = paint(shape)
    if own is None or own[1]:
        return
    node, colour = element(holder, "material"), spaced(own[0])
    element(node, "ambient").text = colour
    element(node, "diffuse").text = colour
    if own[0][3] < 1.0:
        element(holder, "transparency").text = number(1.0 - own[0][3])


def _joint(model: Element, joint: SdfJoint) -> Element:
    node = element(model, "joint", name=joint.name, type=joint.type)
    _pose(node, joint.place, joint.at)
    element(node, "parent").text = joint.parent
    element(node, "child").text = joint.child
    if joint.axis is None:
        return node
    axis = element(node, "axis")
    element(axis, "xyz").text = spaced(joint.axis)
    least = LENGTH if joint.type == "prismatic" else TURN
    limits, dynamics = joint.limits, joint.dynamics
    limit = element(axis, "limit")
    for key, end in (("lower", limits.lower), ("upper", limits.upper)):
        if end is not None:
            element(limit, key).text = number(end, least=least)
    for key, bound in (("effort", dynamics.effort), ("velocity", dynamics.velocity)):
        if bound is not None:
            element(limit, key).text = number(bound)
    if dynamics.damping is not None or dynamics.friction is not None:
        inner = element(axis, "dynamics")
        for key, value in (("damping", dynamics.damping), ("friction", dynamics.friction)):
            element(inner, key).text = number(value or 0.0)
    if joint.follows is not None:
        mimic = element(axis, "mimic", joint=joint.follows.joint, axis="axis")
        element(mimic, "multiplier").text = number(joint.follows.multiplier)
        element(mimic, "offset").text = number(joint.follows.offset, least=least)
        element(mimic, "reference").text = "0"
    return node
