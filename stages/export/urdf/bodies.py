"""Writes the links of a URDF: inertials, visuals and colliders."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from linkwright.stages.export.paints import Paint, paint
from linkwright.stages.formats.numbers import LENGTH, TURN, number, numbers, spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.geometry import Role, Shape
from linkwright.stages.robot.model.poses import from_parts, rpy_from_rotation
from linkwright.stages.robot.model.robot import Array, Inertial, Primitive


def write_link(root: Element, name: str, body: Inertial, has_shapes: bool) -> Element:
    """Writes a link with its inertial, and returns its element. A link without mass has an inertial only if
    it has shapes."""
    node = element(root, "link", name=name)
    # MuJoCo would derive the mass of a link without an inertial from its shapes.
    if body.mass > 0 or has_shapes:
        inertial = element(node, "inertial")
        element(inertial, "origin", xyz=spaced(body.com, least=LENGTH), rpy="0 0 0")
        element(inertial, "mass", value=number(body.mass))
        texts = numbers(body.inertia)
        keys = {"ixx": 0, "ixy": 1, "ixz": 2, "iyy": 4, "iyz": 5, "izz": 8}
        element(inertial, "inertia", **{key: texts[index] for key, index in keys.items()})
    return node


def write_shapes(
    node: Element,
    links: Sequence[tuple[str, Array]],
    shapes: Mapping[tuple[str, Role], Sequence[Shape]],
    material_names: Mapping[Paint, str],
    assets: str,
) -> None:
    """Writes the shapes of `links`, each link at its pose (4, 4) in the link of `node`. `assets`: the prefix
    of mesh paths."""
    roles: tuple[Role, ...] = ("visual", "collision")
    for role in roles:
        shapes_with_poses = ((shape, pose) for link, pose in links for shape in shapes[link, role])
        for shape, link_pose in shapes_with_poses:
            for pose, tag, attributes in _solids(shape, assets):
                holder = element(node, role)
                write_origin(holder, link_pose @ pose)
                element(element(holder, "geometry"), tag, **attributes)
                colour_and_image = paint(shape)
                if colour_and_image is not None:
                    element(holder, "material", name=material_names[colour_and_image])


def _solids(shape: Shape, assets: str) -> Iterator[tuple[Array, str, dict[str, str]]]:
    """Yields the URDF geometries of a shape: link_from_solid (4, 4), tag, attributes."""
    if shape.primitive is None:
        yield np.eye(4), "mesh", {"filename": f"{assets}{shape.file}"}
    else:
        yield from _primitive_solids(shape.primitive)


def _primitive_solids(primitive: Primitive) -> Iterator[tuple[Array, str, dict[str, str]]]:
    """Yields the URDF geometries of a primitive, as `_solids` does."""
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
        # URDF has no capsule, so it becomes a cylinder with a sphere at either end.
        for end in (-size[1] / 2, size[1] / 2):
            yield pose @ from_parts(np.eye(3), np.array([0.0, 0.0, end])), "sphere", radius


def write_origin(parent: Element, pose: Array) -> None:
    """Writes a pose (4, 4) as the <origin> of the element `parent`."""
    rpy = rpy_from_rotation(pose[:3, :3])
    element(parent, "origin", xyz=spaced(pose[:3, 3], least=LENGTH), rpy=spaced(rpy, least=TURN))
