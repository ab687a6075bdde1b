"""What is seen of the bodies of a compiled model, as triangles: how near they are to each other.

A mesh is the triangles of its file; a primitive has corners on its own surface.
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

TURNS = 48
"""Corners round a curved primitive."""

BARREL = np.array([[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]])
"""The outline of a cylinder: radii and heights."""

SOME = 12
"""The most poses at which the distance is measured."""


FEW = 8
"""At so many poses it is looked whether a body is in another."""

CLOSED = 0.999
"""A surface that goes round a point as often holds it: an open shell hardly does."""


@dataclass(slots=True)
class SeenSurfaces:
    """The geoms that are seen, by body. Meshes are made when they are first asked for, one for each body."""

    model: Any
    seen: Mapping[int, Sequence[int]]
    _surfaces: dict[int, tuple[Array, Faces]] = field(default_factory=dict)
    _made: dict[int, Mesh] = field(default_factory=dict)

    def near(self, one: int, other: int, one_from_other: Array, margin: float) -> bool:
        """Whether what is seen of two bodies is within `margin` [m] of each other, of which 0 cuts."""
        found = engine()
        (pose,) = found.poses(one_from_other[None])
        return found.near(self._mesh(one), self._mesh(other), pose, margin)

    def furthest(self, one: int, other: int, poses: Sequence[Array]) -> float:
        """The largest distance [m] at these poses, or at some of them, evenly spread, where they are many."""
        found = engine()
        some = np.linspace(0, len(poses) - 1, min(len(poses), SOME)).astype(int)
        ends = self._mesh(one), self._mesh(other)
        return max(found.apart(*ends, pose) for pose in found.poses(np.array([poses[at] for at in some])))

    def outside(self, one: int, other: int, poses: Sequence[Array]) -> Sequence[Array]:
        """Those of the poses at which neither of two bodies is in the other. The test takes as long as ten of
        how near they are: where it finds none at some of the poses, it is not made at the others."""
        some = poses[:: len(poses) // FEW + 1]
        if not any(self.within(one, other, pose) for pose in some):
            return poses
        return [pose for pose in poses if not self.within(one, other, pose)]

    def within(self, one: int, other: int, one_from_other: Array) -> bool:
        """Whether one of two bodies whose surfaces do not cut is in the other, where that is closed."""
        return self._holds(one, one_from_other, other) or self._holds(other, inverse(one_from_other), one)

    def box(self, body: int) -> tuple[Array, Array]:
        """The least and the largest corner (3,), in the frame of the body."""
        points, _ = self._triangles(body)
        return points.min(axis=0), points.max(axis=0)

    def _holds(self, outer: int, outer_from_inner: Array, inner: int) -> bool:
        corner = outer_from_inner[:3, :3] @ self._triangles(inner)[0][0] + outer_from_inner[:3, 3]
        low, high = self.box(outer)
        inside = bool((corner > low).all() and (corner < high).all())
        return inside and abs(winding(*self._triangles(outer), corner)) > CLOSED

    def _triangles(self, body: int) -> tuple[Array, Faces]:
        if body not in self._surfaces:
            every = [surface(self.model, geom) for geom in self.seen[body]]
            starts = np.cumsum([0, *(len(points) for points, _ in every[:-1])])
            faces = np.concatenate([own + start for (_, own), start in zip(every, starts, strict=True)])
            self._surfaces[body] = np.concatenate([points for points, _ in every]), faces
        return self._surfaces[body]

    def _mesh(self, body: int) -> Mesh:
        if body not in self._made:
            self._made[body] = engine().mesh(*self._triangles(body))
        return self._made[body]


def winding(points: Array, faces: Faces, at: Array) -> float:
    """How often the triangles go round a point: 1 in a solid, 0 outside, anything between in an open shell
    (the solid angles of triangles: Van Oosterom and Strackee, 1983)."""
    a, b, c = (points[faces] - at).swapaxes(0, 1)
    x, y, z = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", *sides) for sides in ((a, b), (b, c), (c, a)))
    above = np.einsum("ij,ij->i", a, np.cross(b, c))
    return float(np.arctan2(above, x * y * z + ab * z + bc * x + ca * y).sum()) / (2.0 * np.pi)


def surface(model: Any, geom: int) -> tuple[Array, Faces]:
    """The corners (n, 3) of a geom in the frame of its body, and its triangles (m, 3)."""
    pose = placed(model.geom_quat[geom], model.geom_pos[geom])
    points, faces = _own(model, geom)
    return points @ pose[:3, :3].T + pose[:3, 3], faces


def _own(model: Any, geom: int) -> tuple[Array, Faces]:
    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == MESH:
        mesh = int(model.geom_dataid[geom])
        first = int(model.mesh_faceadr[mesh])
        faces = model.mesh_face[first : first + int(model.mesh_facenum[mesh])]
        return vertices(model, geom), np.asarray(faces, dtype=np.int64)
    if kind == BOX:
        # Four corners round the axis, from the first quarter on, are a square of this radius.
        points, faces = _turned(BARREL * [np.sqrt(2.0), 1.0], 4)
        return points * size, faces
    if kind == CYLINDER:
        return _turned(BARREL * size[:2], TURNS)
    angles = np.linspace(-np.pi / 2.0, np.pi / 2.0, TURNS // 2 + 2)
    points, faces = _turned(np.column_stack([np.cos(angles), np.sin(angles)]), TURNS)
    if kind == CAPSULE:
        return points * size[0] + [0.0, 0.0, size[1]] * np.sign(points[:, 2:]), faces
    return points * (size if kind == ELLIPSOID else size[0]), faces


def _turned(outline: Array, turns: int) -> tuple[Array, Faces]:
    """An outline of radii and heights (k, 2), from one end of the z axis to the other, turned about it."""
    angles = (np.arange(turns) + 0.5) * (2.0 * np.pi / turns)
    round_ = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [np.column_stack([radius * round_, np.full(turns, height)]) for radius, height in outline]
    at = np.arange(turns)
    after = (at + 1) % turns
    faces = []
    for ring, (low, high) in enumerate(pairwise(outline[:, 0])):
        a, b, c, d = (row + step * turns for step in (ring, ring + 1) for row in (at, after))
        # Where the outline is on the axis, all corners are in one place.
        faces += [np.column_stack([a, b, d])] if low > 0.0 else []
        faces += [np.column_stack([a, d, c])] if high > 0.0 else []
    return np.concatenate(rings), np.concatenate(faces).astype(np.int64)
