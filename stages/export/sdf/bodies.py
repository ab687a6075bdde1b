"""Writes the links of an SDF: inertials, visuals and colliders."""

from collections.abc import Mapping, Sequence

import numpy as np

from linkwright.stages.export.paints import paint
from linkwright.stages.export.sdf.lowering import SdfJoint, SdfJoints
from linkwright.stages.formats.numbers import LENGTH, TURN, number, numbers, spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.model.poses import rpy_from_rotation
from linkwright.stages.robot.model.robot import Array, Inertial, Primitive


def write_link(
    model: Element, name: str, body: Inertial, carriers: Mapping[str, SdfJoint], lowered: SdfJoints
) -> Element:
    """Writes a link with its inertial, in the frame of the joint that carries it."""
    node = element(model, "link", name=name)
    if name in carriers:
        write_pose(node, np.eye(4), carriers[name].name)
    elif name in lowered.floating:
        above, pose = lowered.floating[name]
        write_pose(node, pose, above)
    inertial = element(node, "inertial")
    element(inertial, "pose").text = f"{spaced(body.com, least=LENGTH)} 0 0 0"
    element(inertial, "mass").text = number(body.mass)
    tensor, texts = element(inertial, "inertia"), numbers(body.inertia)
    for key, index in (("ixx", 0), ("ixy", 1), ("ixz", 2), ("iyy", 4), ("iyz", 5), ("izz", 8)):
        element(tensor, key).text = texts[index]
    return node


def write_colliders(
    node: Element,
    link: str,
    shapes: Sequence[Shape],
    assets: str,
    sibling_names: set[str],
    masks: Mapping[tuple[str, int], int],
) -> list[str]:
    """Writes the colliders of a link, and returns their names."""
    names = []
    for index, (holder, shape) in enumerate(
        zip(write_shapes(node, shapes, "collision", assets, sibling_names), shapes, strict=True)
    ):
        _surface(holder, shape, masks.get((link, index)))
        names.append(str(holder.get("name")))
    return names


def write_shapes(
    node: Element, shapes: Sequence[Shape], tag: str, assets: str, sibling_names: set[str]
) -> list[Element]:
    """Writes the shapes of a role, and returns their elements."""
    holders = []
    for count, shape in enumerate(shapes, 1):
        name = f"{tag}_{count}"
        sibling_names.add(name)
        holder = element(node, tag, name=name)
        holders.append(holder)
        _geometry(holder, shape, assets)
        if tag == "visual":
            _material(holder, shape)
    return holders


def _surface(holder: Element, shape: Shape, mask: int | None) -> None:
    """Writes the friction of a collider, and its mask: it collides with what shares a bit of the mask."""
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
    write_pose(holder, shape.primitive.link_from_shape)
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
    """Writes the colour of a shape, unless it is a mesh with an image, which has a material of its own."""
    colour_and_image = paint(shape)
    if colour_and_image is None or colour_and_image[1]:
        return
    node, colour = element(holder, "material"), spaced(colour_and_image[0])
    element(node, "ambient").text = colour
    element(node, "diffuse").text = colour
    if colour_and_image[0][3] < 1.0:
        element(holder, "transparency").text = number(1.0 - colour_and_image[0][3])


def write_pose(above: Element, pose: Array, relative_to: str | None = None) -> None:
    """Writes a pose (4, 4) in the frame `relative_to`, by default that of the element `above`."""
    position = spaced(pose[:3, 3], least=LENGTH)
    angles = spaced(rpy_from_rotation(pose[:3, :3]), least=TURN)
    element(above, "pose", relative_to=relative_to).text = f"{position} {angles}"
