"""Measures the distances of the visual shapes of a compiled model's bodies, as triangles.

Meshes have the triangles of their files; primitives have triangles with corners on their surface.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.contact.clearance import Mesh, engine
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.model.poses import placed
from linkwright.stages.validate.model.shapes import BOX, CAPSULE, CYLINDER, ELLIPSOID, MESH, vertices

Faces = npt.NDArray[np.int64]

CORNERS = 48
"""Number of corners around a round primitive."""

CYLINDER_OUTLINE = np.array([[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]])
"""The outline of a cylinder: radii and heights, as shares of its own."""

MAX_MEASURED_POSES = 12
"""Largest number of poses at which the distance is measured."""


MAX_SAMPLED_POSES = 8
"""Largest number of poses in the first test for a body inside another; only a hit leads to a test of all."""

MIN_WINDING = 0.999
"""Smallest winding number of a surface around a point inside it: open shells hardly reach it."""


@dataclass(slots=True)
class SeenSurfaces:
    """The surfaces of bodies, each made at its first use."""

    model: Any
    seen: Mapping[int, Sequence[int]]
    """Body → its visual geoms."""

    _surfaces: dict[int, tuple[Array, Faces]] = field(default_factory=dict)
    _meshes: dict[int, Mesh] = field(default_factory=dict)

    def near(self, first: int, second: int, first_from_second: Array, margin: float) -> bool:
        """Tells whether the visual shapes of two bodies are within `margin` [m] of each other; with a margin
        of 0, whether they intersect."""
        distances = engine()
        (pose,) = distances.poses(first_from_second[None])
        return distances.near(self._mesh(first), self._mesh(second), pose, margin)

    def furthest(self, first: int, second: int, poses: Sequence[Array]) -> float:
        """Returns the largest distance [m] at these poses, or at an even sample of many poses."""
        distances = engine()
        sample = np.linspace(0, len(poses) - 1, min(len(poses), MAX_MEASURED_POSES)).astype(int)
        ends = self._mesh(first), self._mesh(second)
        return max(
            distances.distance(*ends, pose)
            for pose in distances.poses(np.array([poses[at] for at in sample]))
        )

    def outside(self, first: int, second: int, poses: Sequence[Array]) -> Sequence[Array]:
        """Returns the poses at which neither of two bodies is inside the other. A test takes as long as ten
        distances. If no body is inside the other in a sample of the poses, the other poses are not tested."""
        sample = poses[:: len(poses) // MAX_SAMPLED_POSES + 1]
        if not any(self.within(first, second, pose) for pose in sample):
            return poses
        return [pose for pose in poses if not self.within(first, second, pose)]

    def within(self, first: int, second: int, first_from_second: Array) -> bool:
        """Tells whether one of two bodies whose surfaces do not intersect is inside the other, which is
        closed."""
        return self._holds(first, first_from_second, second) or self._holds(
            second, inverse(first_from_second), first
        )

    def box(self, body: int) -> tuple[Array, Array]:
        """Returns the lower and the upper corner (3,) of a body's box, in its frame."""
        points, _ = self._triangles(body)
        return points.min(axis=0), points.max(axis=0)

    def _holds(self, outer: int, outer_from_inner: Array, inner: int) -> bool:
        """Tells whether the closed surface of a body contains another body."""
        # The surfaces do not intersect, so that a single corner tells for the whole inner body.
        corner = outer_from_inner[:3, :3] @ self._triangles(inner)[0][0] + outer_from_inner[:3, 3]
        low, high = self.box(outer)
        inside = bool((corner > low).all() and (corner < high).all())
        return inside and abs(winding(*self._triangles(outer), corner)) > MIN_WINDING

    def _triangles(self, body: int) -> tuple[Array, Faces]:
        """Returns the corners (n, 3) [m] of all visual shapes of a body, in its frame, and faces (m, 3)."""
        if body not in self._surfaces:
            surfaces = [surface(self.model, geom) for geom in self.seen[body]]
            starts = np.cumsum([0, *(len(points) for points, _ in surfaces[:-1])])
            faces = np.concatenate(
                [triangles + start for (_, triangles), start in zip(surfaces, starts, strict=True)]
            )
            self._surfaces[body] = np.concatenate([points for points, _ in surfaces]), faces
        return self._surfaces[body]

    def _mesh(self, body: int) -> Mesh:
        if body not in self._meshes:
            self._meshes[body] = engine().mesh(*self._triangles(body))
        return self._meshes[body]


def winding(points: Array, faces: Faces, point: Array) -> float:
    """Returns the winding number of triangles around a point (3,): 1 in a solid, 0 outside, and between these
    in an open shell. It sums the solid angles of the triangles (Van Oosterom and Strackee, 1983)."""
    a, b, c = (points[faces] - point).swapaxes(0, 1)
    x, y, z = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", *sides) for sides in ((a, b), (b, c), (c, a)))
    above = np.einsum("ij,ij->i", a, np.cross(b, c))
    # Half of each solid angle: its tangent is (a · b × c) / (xyz + …).
    return float(np.arctan2(above, x * y * z + ab * z + bc * x + ca * y).sum()) / (2.0 * np.pi)


def surface(model: Any, geom: int) -> tuple[Array, Faces]:
    """Returns the corners (n, 3) of a geom in the frame of its body, and its triangles (m, 3)."""
    pose = placed(model.geom_quat[geom], model.geom_pos[geom])
    points, faces = _local_surface(model, geom)
    return points @ pose[:3, :3].T + pose[:3, 3], faces


def _local_surface(model: Any, geom: int) -> tuple[Array, Faces]:
    """Returns the corners (n, 3) of a geom in its own frame, and its triangles (m, 3)."""
    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == MESH:
        mesh = int(model.geom_dataid[geom])
        first = int(model.mesh_faceadr[mesh])
        faces = model.mesh_face[first : first + int(model.mesh_facenum[mesh])]
        return vertices(model, geom), np.asarray(faces, dtype=np.int64)
    if kind == BOX:
        # Four corners around the axis, with this radius and the first at 45°, are the square (±1, ±1).
        points, faces = _surface_of_revolution(CYLINDER_OUTLINE * [np.sqrt(2.0), 1.0], 4)
        return points * size, faces
    if kind == CYLINDER:
        return _surface_of_revolution(CYLINDER_OUTLINE * size[:2], CORNERS)
    angles = np.linspace(-np.pi / 2.0, np.pi / 2.0, CORNERS // 2 + 2)
    points, faces = _surface_of_revolution(np.column_stack([np.cos(angles), np.sin(angles)]), CORNERS)
    if kind == CAPSULE:
        return points * size[0] + [0.0, 0.0, size[1]] * np.sign(points[:, 2:]), faces
    return points * (size if kind == ELLIPSOID else size[0]), faces


def _surface_of_revolution(outline: Array, corner_count: int) -> tuple[Array, Faces]:
    """Returns the surface of revolution of an outline (k, 2) of radii and heights, from one end of the z axis
    to the other. `corner_count`: the number of corners around the axis."""
    angles = (np.arange(corner_count) + 0.5) * (2.0 * np.pi / corner_count)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [np.column_stack([radius * circle, np.full(corner_count, height)]) for radius, height in outline]
    corners = np.arange(corner_count)
    next_corners = (corners + 1) % corner_count
    faces = []
    for ring, (low, high) in enumerate(pairwise(outline[:, 0])):
        # The corners of a row of quadrilaterals: a, b on the lower ring, c, d above them.
        a, b, c, d = (
            row + step * corner_count for step in (ring, ring + 1) for row in (corners, next_corners)
        )
        # A ring with radius 0 is a single point, so that one of the two triangles has no area.
        faces += [np.column_stack([a, b, d])] if low > 0.0 else []
        faces += [np.column_stack([a, d, c])] if high > 0.0 else []
    return np.concatenate(rings), np.concatenate(faces).astype(np.int64)
