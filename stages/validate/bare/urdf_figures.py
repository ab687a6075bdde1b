"""Reads the masses and sizes of the bodies of a URDF, from its text and its meshes."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array, Inertial
from linkwright.stages.validate.bare.figures import BareBody, ShapeFigures, box_corners
from linkwright.stages.validate.bare.findings import parse_number, parse_numbers
from linkwright.stages.validate.bare.mesh_files import outermost_points
from linkwright.stages.validate.reading.asset_files import referenced_files
from linkwright.stages.validate.reading.documents import ModelDocument, title_of

_INERTIA_ATTRIBUTES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def figures(document: ModelDocument) -> list[BareBody]:
    """Returns every link, in the order of the file. Shapes that cannot be read are left out."""
    joints = {_link_at(joint, "child"): joint for joint in document.root.iterfind("joint")}
    meshes: dict[Path, Array | None] = {}
    mesh_paths = {file.element: file.path for file in referenced_files(document)}
    bodies = []
    for link in document.root.iterfind("link"):
        name = link.get("name", "")
        shapes = [_shape(element, mesh_paths, meshes) for element in link.iterchildren("visual", "collision")]
        above = joints.get(name)
        parent = "" if above is None else _link_at(above, "parent")
        fixed = name == "world" if above is None else above.get("type") == "fixed"
        bodies.append(_body(link, parent, fixed, _root_from_link(name, joints), shapes))
    return bodies


def _link_at(joint: Element, role: str) -> str:
    """Returns the name of a joint's parent or child link (`role`); "" if it is missing."""
    end = joint.find(role)
    return "" if end is None else str(end.get("link", ""))


def _root_from_link(name: str, joints: dict[str, Element]) -> Array:
    """Returns the pose (4, 4) of a link in the root's frame, with all joints at zero."""
    pose, visited = np.eye(4), set()
    while name in joints and name not in visited:
        visited.add(name)
        pose = _pose(joints[name]) @ pose
        name = _link_at(joints[name], "parent")
    return pose


def _pose(element: Element) -> Array:
    """Returns the pose (4, 4) of an element's <origin>; the identity if it is missing or not finite."""
    origin = element.find("origin")
    xyz, rpy = [0.0] * 3, [0.0] * 3
    if origin is not None:
        xyz, rpy = parse_numbers(origin.get("xyz")) or xyz, parse_numbers(origin.get("rpy")) or rpy
    if len(xyz) != 3 or len(rpy) != 3 or not np.isfinite([*xyz, *rpy]).all():
        return np.eye(4)
    return from_parts(rotation_from_rpy((rpy[0], rpy[1], rpy[2])), np.array(xyz))


def _body(
    link: Element, parent: str, fixed: bool, world: Array, shapes: Sequence[ShapeFigures | None]
) -> BareBody:
    title = title_of(link)
    read = tuple(shape for shape in shapes if shape is not None)
    return BareBody(
        link.get("name", ""),
        parent,
        fixed,
        world,
        _inertial(link.find("inertial")),
        read,
        len(read) == len(shapes),
        {
            "inertia": (f"inertia of {title}", "ixx"),
            "centre": (f"origin of {title}", "xyz"),
            "mass": (f"mass of {title}", "value"),
            "shape": (title, "visual"),
        },
    )


def _inertial(inertial: Element | None) -> Inertial:
    """Returns the inertial of a link; zero if it is missing or not finite, which other checks report."""
    mass, com, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    if inertial is not None:
        pose = _pose(inertial)
        weight, tensor = inertial.find("mass"), inertial.find("inertia")
        mass = (parse_number(weight.get("value")) if weight is not None else 0.0) or 0.0
        com = pose[:3, 3]
        values = (
            [parse_number(tensor.get(name)) or 0.0 for name in _INERTIA_ATTRIBUTES]
            if tensor is not None
            else [0.0] * 6
        )
        if np.isfinite(values).all():
            xx, xy, xz, yy, yz, zz = values
            inertia = pose[:3, :3] @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ pose[:3, :3].T
    return Inertial(mass if np.isfinite(mass) else 0.0, com, inertia)


def _shape(
    element: Element, mesh_paths: dict[Element, Path | None], meshes: dict[Path, Array | None]
) -> ShapeFigures | None:
    """Returns the shape of a <visual> or <collision>; None if it cannot be read. `mesh_paths`: <mesh> → its
    file; `meshes`: the points of the files read so far, to which this one's are added."""
    shape = next(element.iterfind("geometry/*"), None)
    if shape is None:
        return None
    pose, collides = _pose(element), element.tag == "collision"
    attribute = {"mesh": "scale", "box": "size", "sphere": "radius"}.get(str(shape.tag), "length")
    place = f"origin of {title_of(element)}", "xyz"
    if shape.tag != "mesh":
        half = _half_size(shape)
        if half is None:
            return None
        corners = box_corners(np.zeros(3), half, pose)
        return ShapeFigures(corners, collides, not collides, False, title_of(shape), attribute, place)
    path = mesh_paths.get(shape)
    if path is None:
        return None
    if path not in meshes:
        meshes[path] = outermost_points(path)
    points, scale = meshes[path], parse_numbers(shape.get("scale", "1 1 1")) or []
    if points is None or len(scale) != 3 or not np.isfinite(scale).all():
        return None
    placed = (points * scale) @ pose[:3, :3].T + pose[:3, 3]
    return ShapeFigures(placed, collides, not collides, True, title_of(shape), attribute, place)


def _half_size(shape: Element) -> Array | None:
    """Returns half the sides (3,) [m] of the box around a primitive; None for an unknown shape or a box
    without three sides. A missing radius or length counts as 0."""
    size = parse_numbers(shape.get("size")) or []
    radius, length = ((parse_numbers(shape.get(name)) or [0.0])[0] for name in ("radius", "length"))
    if shape.tag == "box":
        return np.array(size) / 2 if len(size) == 3 else None
    if shape.tag == "sphere":
        return np.full(3, radius)
    if shape.tag not in ("cylinder", "capsule"):
        return None
    return np.array([radius, radius, length / 2 + (radius if shape.tag == "capsule" else 0.0)])
