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
    """Writes a link with its inertial, and returns its element. The link has the frame of the joint that
    carries it. `body`: its inertial; `carriers`: link → the joint that carries it."""
    node = element(model, "link", name=name)
    if name in carriers:
        write_pose(node, np.eye(4), carriers[name].name)
    elif name in lowered.floating:
        parent_link, pose = lowered.floating[name]
        write_pose(node, pose, parent_link)
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
    """Writes the colliders of a link, and returns their names. `assets`: the prefix of mesh paths;
    `sibling_names` gets the names; `masks`: (link, index of the collider) → mask."""
    names = []
    for index, (holder, shape) in enumerate(
        zip(write_shapes(node, shapes, "collision", assets, sibling_names), shapes, strict=True)
    ):
        _write_surface(holder, shape, masks.get((link, index)))
        names.append(str(holder.get("name")))
    return names


def write_shapes(
    node: Element, shapes: Sequence[Shape], tag: str, assets: str, sibling_names: set[str]
) -> list[Element]:
    """Writes the shapes of a role, whose name is `tag`, and returns their elements. `assets`: the prefix of
    mesh paths; `sibling_names` gets the names of the shapes."""
    holders = []
    for count, shape in enumerate(shapes, 1):
        name = f"{tag}_{count}"
        sibling_names.add(name)
        holder = element(node, tag, name=name)
        holders.append(holder)
        _write_geometry(holder, shape, assets)
        if tag == "visual":
            _write_material(holder, shape)
    return holders


def _write_surface(holder: Element, shape: Shape, mask: int | None) -> None:
    """Writes the friction of a collider, and its mask, if these are set."""
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


def _write_geometry(holder: Element, shape: Shape, assets: str) -> None:
    """Writes the mesh of a shape, or its primitive and pose."""
    if shape.primitive is None:
        mesh = element(element(holder, "geometry"), "mesh")
        element(mesh, "uri").text = f"{assets}{shape.file}"
        return
    write_pose(holder, shape.primitive.link_from_shape)
    _write_primitive(element(holder, "geometry"), shape.primitive)


def _write_primitive(geometry: Element, primitive: Primitive) -> None:
    """Writes a primitive in an element <geometry>."""
    node, size = element(geometry, primitive.kind), primitive.size
    if primitive.kind == "box":
        element(node, "size").text = spaced(size)
        return
    element(node, "radius").text = number(size[0])
    if primitive.kind != "sphere":
        element(node, "length").text = number(size[1])


def _write_material(holder: Element, shape: Shape) -> None:
    """Writes the colour of a shape, unless it is a mesh with an image, which has a material of its own."""
    colour, image = paint(shape) or (None, "")
    if colour is None or image:
        return
    node, colour_text = element(holder, "material"), spaced(colour)
    element(node, "ambient").text = colour_text
    element(node, "diffuse").text = colour_text
    alpha = colour[3]
    if alpha < 1.0:
        element(holder, "transparency").text = number(1.0 - alpha)


def write_pose(node: Element, pose: Array, relative_to: str | None = None) -> None:
    """Writes the pose (4, 4) of an element in the frame `relative_to`, by default that of its parent."""
    position = spaced(pose[:3, 3], least=LENGTH)
    angles = spaced(rpy_from_rotation(pose[:3, :3]), least=TURN)
    element(node, "pose", relative_to=relative_to).text = f"{position} {angles}"
