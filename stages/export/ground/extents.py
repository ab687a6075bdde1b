"""Measures how far the shapes of a robot reach in a direction."""

from collections.abc import Iterable, Mapping

import numpy as np

from linkwright.stages.formats.meshes.points import mesh_points
from linkwright.stages.robot.model.geometry import Geometry, Role, Shape
from linkwright.stages.robot.model.robot import Array, Primitive

RIM_POINTS = 16
"""Number of points on each rim of a cylinder."""


class Extents:
    """The extents of a robot's shapes, with its links at the poses `world_from_link` (4, 4)."""

    def __init__(self, geometry: Geometry, world_from_link: Mapping[str, Array]) -> None:
        self._geometry = geometry
        self._poses = world_from_link
        self._points: dict[str, Array] = {}
        self._shapes: dict[tuple[str, Role], list[Shape]] = {}
        for shape in geometry.shapes:
            self._shapes.setdefault((shape.link, shape.role), []).append(shape)

    def min_along(self, links: Iterable[str], role: Role, direction: Array) -> float:
        """Returns the minimum of direction · x [m] over all points x of these links' shapes in the world;
        infinite without shapes. `direction` (3,): a unit vector in the world."""
        return min(
            (
                self._min_of_shape(shape, direction)
                for link in links
                for shape in self._shapes.get((link, role), ())
            ),
            default=np.inf,
        )

    def points_below(self, link: str, role: Role, direction: Array, limit: float) -> Array:
        """Returns the corners (n, 3) [m] of a link's shapes, in the world, with direction · x up to `limit`.
        A round shape has the points that are the furthest against the direction, and a disc that lies flat
        has points of its rim."""
        parts = [np.zeros((0, 3))]
        for shape in self._shapes.get((link, role), ()):
            pose = self._poses[link]
            along = pose[:3, :3].T @ direction
            corners = self._mesh(shape.file) if shape.file else _corners(shape.primitive, along)
            points = corners @ pose[:3, :3].T + pose[:3, 3]
            parts.append(points[points @ direction <= limit])
        return np.concatenate(parts)

    def box(self) -> tuple[Array, Array]:
        """Returns the lower and upper corner (3,) [m] of the box around all shapes, in the world; infinity
        and minus infinity without a shape."""
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for shape in (shape for shapes in self._shapes.values() for shape in shapes):
            shape_box = self._box(shape)
            low, high = np.minimum(low, shape_box[0]), np.maximum(high, shape_box[1])
        return low, high

    def _box(self, shape: Shape) -> tuple[Array, Array]:
        if shape.file is None:
            ends = [self._min_of_shape(shape, sign * axis) for sign in (1.0, -1.0) for axis in np.eye(3)]
            return np.array(ends[:3]), -np.array(ends[3:])
        pose = self._poses[shape.link]
        points = self._mesh(shape.file) @ pose[:3, :3].T
        low, high = points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf)
        return low + pose[:3, 3], high + pose[:3, 3]

    def _min_of_shape(self, shape: Shape, direction: Array) -> float:
        world_from_link = self._poses[shape.link]
        along = world_from_link[:3, :3].T @ direction
        offset = float(direction @ world_from_link[:3, 3])
        if shape.primitive is not None:
            return offset + _min_of_primitive(shape.primitive, along)
        assert shape.file is not None
        return offset + float((self._mesh(shape.file) @ along).min(initial=np.inf))

    def _mesh(self, file: str) -> Array:
        if file not in self._points:
            self._points[file] = mesh_points(file, self._geometry.files[file])
        return self._points[file]


def _min_of_primitive(shape: Primitive, direction: Array) -> float:
    """Returns the minimum [m] of direction · x over a primitive's points x. Points and `direction` (3,) are
    in the frame of its link."""
    center = float(direction @ shape.link_from_shape[:3, 3])
    along = shape.link_from_shape[:3, :3].T @ direction
    if shape.kind == "box":
        return center - float(np.abs(along) @ shape.size) / 2
    radius = shape.size[0]
    if shape.kind == "sphere":
        return center - radius
    half = shape.size[1] / 2
    reach = radius if shape.kind == "capsule" else radius * float(np.hypot(along[0], along[1]))
    return center - abs(float(along[2])) * half - reach


def _corners(shape: Primitive | None, direction: Array) -> Array:
    """Returns the points (n, 3) of a primitive, in the frame of its link, on which it can lie. `direction`
    (3,): the ground's normal in that frame."""
    assert shape is not None
    along = shape.link_from_shape[:3, :3].T @ direction
    if shape.kind == "box":
        points = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * shape.size / 2
    elif shape.kind == "cylinder":
        points = _rims(shape.size[0], shape.size[1], along)
    else:
        half = shape.size[1] / 2 if shape.kind == "capsule" else 0.0
        points = np.array([[0.0, 0.0, -half], [0.0, 0.0, half]]) - shape.size[0] * along
    in_link: Array = points @ shape.link_from_shape[:3, :3].T + shape.link_from_shape[:3, 3]
    return in_link


def _rims(radius: float, length: float, along: Array) -> Array:
    """Returns the points of both rims of a cylinder. Each rim begins with its furthest point against
    `along`."""
    angles = np.arctan2(-along[1], -along[0]) + 2 * np.pi * np.arange(RIM_POINTS) / RIM_POINTS
    rim = radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(RIM_POINTS)], axis=1)
    return np.concatenate([rim + np.array([0.0, 0.0, end]) for end in (-length / 2, length / 2)])
