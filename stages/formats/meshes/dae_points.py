"""Reads the points of the shapes that a COLLADA file (DAE) shows.

Lengths are in metres by the file's unit; the file's "up" axis is ignored, as in RViz and Pinocchio.
"""

import math
from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats import xml
from linkwright.stages.formats.damaged import Damaged
from linkwright.stages.formats.xml import Element

Points = npt.NDArray[np.float64]

_MAX_DEPTH = 64
"""Largest depth of nested nodes."""

_MAX_USES = 1 << 14
"""Largest number of uses of shapes and nodes: nodes may refer to each other."""

_MAX_POINTS = 1 << 24
"""Largest number of points of all uses of shapes together: they take 400 MB."""

_MAX_OFFSET = 1000
"""Largest offset of an input of a face."""

_FACE_TAGS = frozenset(("triangles", "polylist", "polygons", "tristrips", "trifans"))
"""Elements of a mesh with faces, whose <p> have the indices of the points."""

_UNSUPPORTED_TAGS = frozenset(("instance_controller", "lookat", "skew"))
"""Elements of a node that would place or add shapes."""


def dae_points(data: bytes) -> Points:
    """Returns the points (n, 3) [m] of all shapes of the scene; a point may be there several times.

    Raises xml.Malformed if the file is not XML; Damaged if it is incomplete, has unsupported elements (skins,
    skewed nodes), or uses its nodes or points too often.
    """
    root = xml.parse(data, large=True)
    by_id = {element.get("id"): element for element in root.iter() if element.get("id")}
    unit = root.find("{*}asset/{*}unit")
    scale = 1.0 if unit is None else _numbers(unit.get("meter", "1"), 1)[0]
    scene = _named(root.find("{*}scene/{*}instance_visual_scene"), by_id)
    uses = list(_uses(scene, np.eye(4), by_id, 0, [_MAX_USES]))
    shapes = {id(shape): shape for shape, _ in uses}
    points_by_shape = {key: _mesh_points(shape, by_id) for key, shape in shapes.items()}
    if sum(len(points_by_shape[id(shape)]) for shape, _ in uses) > _MAX_POINTS:
        msg = f"its shapes have more than {_MAX_POINTS} points"
        raise Damaged(msg)
    placed = [points_by_shape[id(shape)] @ pose[:3, :3].T + pose[:3, 3] for shape, pose in uses]
    points: Points = scale * np.concatenate([np.zeros((0, 3)), *placed])
    return points


def _uses(
    node: Element, scene_from_parent: Points, by_id: Mapping[str, Element], depth: int, uses_left: list[int]
) -> Iterator[tuple[Element, Points]]:
    """Yields the geometries below a node, each with scene_from_geometry (4, 4). `uses_left`: the number of
    further uses that are allowed; a list, so that all calls count together."""
    uses_left[0] -= 1
    if depth > _MAX_DEPTH or uses_left[0] < 0:
        msg = "its nodes are too many, or contain themselves"
        raise Damaged(msg)
    pose = scene_from_parent
    for child in node:
        kind = _local(child)
        if kind in _UNSUPPORTED_TAGS:
            msg = f"<{kind}> is not supported"
            raise Damaged(msg)
        if kind in _VALUE_COUNTS:
            pose = pose @ _transform(kind, child)
        elif kind == "instance_geometry":
            yield _named(child, by_id), pose
        elif kind == "node":
            yield from _uses(child, pose, by_id, depth + 1, uses_left)
        elif kind == "instance_node":
            yield from _uses(_named(child, by_id), pose, by_id, depth + 1, uses_left)


_VALUE_COUNTS: Mapping[str, int] = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3}
"""Elements that move the content of a node → the number of their values."""


def _transform(kind: str, element: Element) -> Points:
    """Returns the transform (4, 4) of an element of this tag. A rotation is x, y, z of its axis and the angle
    [deg]."""
    values = np.array(_numbers(element.text or "", _VALUE_COUNTS[kind]))
    pose = np.eye(4)
    if kind == "matrix":
        return values.reshape(4, 4)
    if kind == "translate":
        pose[:3, 3] = values
    elif kind == "scale":
        pose[:3, :3] = np.diag(values)
    else:
        # Rodrigues' formula; a rotation about no axis is none.
        x, y, z = values[:3] / (np.linalg.norm(values[:3]) or 1.0)
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        angle = math.radians(values[3])
        pose[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return pose


def _mesh_points(geometry: Element, by_id: Mapping[str, Element]) -> Points:
    """Returns the points (n, 3) that the faces of a geometry use, in its own frame and unit."""
    points_of_faces = [np.zeros((0, 3))]
    for faces in (child for child in geometry.iterfind("{*}mesh/*") if _local(child) in _FACE_TAGS):
        inputs = {entry.get("semantic"): entry for entry in faces.iterfind("{*}input")}
        stride = 1 + max((_whole(entry.get("offset", "0")) for entry in inputs.values()), default=0)
        vertices = _named(inputs.get("VERTEX"), by_id, "source")
        position = vertices.find("{*}input[@semantic='POSITION']")
        array = _named(position, by_id, "source").find("{*}float_array")
        values = np.array(_numbers("" if array is None else array.text or ""))
        # Three numbers for each point, as exporters write them; the accessor's own stride is not read.
        points = values[: len(values) // 3 * 3].reshape(-1, 3)
        first = _whole(inputs["VERTEX"].get("offset", "0"))
        for text in faces.iterfind("{*}p"):
            indices = np.unique(np.array(_numbers(text.text or ""))[first::stride])
            if not ((indices >= 0) & (indices < len(points))).all():
                msg = "a face has a point that does not exist"
                raise Damaged(msg)
            points_of_faces.append(points[indices.astype(np.int64)])
    return np.concatenate(points_of_faces)


def _local(element: Element) -> str:
    """Returns an element's tag without its namespace and prefix."""
    return str(element.tag).rpartition("}")[2]


def _whole(text: str) -> int:
    """Returns the offset in a text. Raises Damaged if it is below 0 or above the limit."""
    (value,) = _numbers(text, 1)
    if not 0 <= value <= _MAX_OFFSET:
        msg = "an offset is out of range"
        raise Damaged(msg)
    return int(value)


def _named(element: Element | None, by_id: Mapping[str, Element], attribute: str = "url") -> Element:
    """Returns the element whose id an element has in an attribute. Raises Damaged without such an element."""
    name = "" if element is None else element.get(attribute, "").removeprefix("#")
    if name not in by_id:
        msg = "it refers to an element that does not exist"
        raise Damaged(msg)
    return by_id[name]


def _numbers(text: str, count: int | None = None) -> list[float]:
    """Returns the numbers in a text. Raises Damaged for other texts, and for another number of them than
    `count`."""
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        msg = "a number is expected"
        raise Damaged(msg) from None
    if count not in (None, len(values)):
        msg = f"expected {count} numbers"
        raise Damaged(msg)
    return values
