"""The bodies of a URDF by mass and size, from its text and its meshes."""

import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stages.formats.mesh_points import mesh_points
from stages.formats.xml import Element
from stages.robot.model import Array
from stages.robot.poses import from_parts, rotation_from_rpy
from stages.validate.asset_files import named_files
from stages.validate.bare.figures import ShapeFigures, WeighedBody, box_corners
from stages.validate.bare.findings import number, numbers
from stages.validate.documents import ModelDocument, called

_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def figures(document: ModelDocument) -> list[WeighedBody]:
    """Every link, in the order of the file; a mesh that cannot be read is left out."""
    joints = {_end(joint, "child"): joint for joint in document.root.iterfind("joint")}
    boxes: dict[Path, tuple[Array, Array] | None] = {}
    places = {one.element: one.path for one in named_files(document)}
    found = []
    for link in document.root.iterfind("link"):
        name = link.get("name", "")
        shapes = [_shape(visual, places, boxes) for visual in link.iterchildren("visual", "collision")]
        above = joints.get(name)
        parent = "" if above is None else _end(above, "parent")
        fixed = above is not None and above.get("type") == "fixed"
        found.append(_body(link, parent, fixed, _world(name, joints), shapes))
    return found


def _end(joint: Element, role: str) -> str:
    end = joint.find(role)
    return "" if end is None else str(end.get("link", ""))


def _world(name: str, joints: dict[str, Element]) -> Array:
    pose, seen = np.eye(4), set()
    while name in joints and name not in seen:
        seen.add(name)
        pose = _pose(joints[name]) @ pose
        name = _end(joints[name], "parent")
    return np.asarray(pose[:3, 3])


def _pose(element: Element) -> Array:
    origin = element.find("origin")
    xyz, rpy = [0.0] * 3, [0.0] * 3
    if origin is not None:
        xyz, rpy = numbers(origin.get("xyz")) or xyz, numbers(origin.get("rpy")) or rpy
    if len(xyz) != 3 or len(rpy) != 3 or not np.isfinite([*xyz, *rpy]).all():
        return np.eye(4)
    return from_parts(rotation_from_rpy((rpy[0], rpy[1], rpy[2])), np.array(xyz))


def _body(
    link: Element, parent: str, fixed: bool, world: Array, shapes: Sequence[ShapeFigures | None]
) -> WeighedBody:
    inertial = link.find("inertial")
    mass, com, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    own = called(link)
    if inertial is not None:
        pose = _pose(inertial)
        weight, tensor = inertial.find("mass"), inertial.find("inertia")
        mass = (number(weight.get("value")) if weight is not None else 0.0) or 0.0
        com = pose[:3, 3]
        values = [number(tensor.get(name)) or 0.0 for name in _MOMENTS] if tensor is not None else [0.0] * 6
        if np.isfinite(values).all():
            xx, xy, xz, yy, yz, zz = values
            inertia = pose[:3, :3] @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ pose[:3, :3].T
    places = (f"mass of {own}", "value"), (f"inertia of {own}", "ixx"), (f"origin of {own}", "xyz")
    read = tuple(shape for shape in shapes if shape is not None)
    whole = len(read) == len(shapes)
    return WeighedBody(link.get("name", ""), parent, fixed, world, mass, com, inertia, read, whole, *places)


def _shape(
    visual: Element, places: dict[Element, Path | None], boxes: dict[Path, tuple[Array, Array] | None]
) -> ShapeFigures | None:
    shape = next(visual.iterfind("geometry/*"), None)
    if shape is None:
        return None
    pose, collides = _pose(visual), visual.tag == "collision"
    attribute = {"mesh": "scale", "box": "size", "sphere": "radius"}.get(str(shape.tag), "length")
    place = f"origin of {called(visual)}", "xyz"
    if shape.tag != "mesh":
        half = _half(shape)
        if half is None:
            return None
        corners = box_corners(np.zeros(3), half, pose)
        return ShapeFigures(corners, collides, False, called(shape), attribute, place)
    path = places.get(shape)
    if path is None:
        return None
    if path not in boxes:
        boxes[path] = _box(path)
    box, scale = boxes[path], numbers(shape.get("scale", "1 1 1")) or []
    if box is None or len(scale) != 3:
        return None
    low, high = box[0] * scale, box[1] * scale
    corners = box_corners((low + high) / 2, np.abs(high - low) / 2, pose)
    return ShapeFigures(corners, collides, True, called(shape), attribute, place)


def _half(shape: Element) -> Array | None:
    values = [numbers(shape.get(name)) or [] for name in ("size", "radius", "length")]
    size, (radius, length) = values[0], ((one or [0.0])[0] for one in values[1:])
    if shape.tag == "box":
        return np.array(size) / 2 if len(size) == 3 else None
    if shape.tag == "sphere":
        return np.full(3, radius)
    if shape.tag not in ("cylinder", "capsule"):
        return None
    return np.array([radius, radius, length / 2 + (radius if shape.tag == "capsule" else 0.0)])


def _box(path: Path) -> tuple[Array, Array] | None:
    """The box around a mesh, in its own unit; None where it is of another format, or not whole."""
    if path.suffix.lower() not in (".stl", ".obj") or not path.is_file():
        return None
    try:
        points = mesh_points(f"a{path.suffix.lower()}", path.read_bytes())
    except (ValueError, IndexError, struct.error):
        return None
    finite = points[np.isfinite(points).all(axis=1)]
    return (finite.min(axis=0), finite.max(axis=0)) if len(finite) else None
