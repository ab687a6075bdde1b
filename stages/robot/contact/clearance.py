"""Measures the distance of two meshes, and the penetration depth of two convex solids, at many poses.

Both come from Coal, the BVH and GJK/EPA library of Pinocchio, or from python-fcl where Coal has no wheel, as
on Windows. The results of the two agreed on all robots on which they were compared. manifold3d's `min_gap`
takes a hundred times as long.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from linkwright.stages.robot.model.robot import Array

Mesh = Any
"""A mesh in an engine's own form."""

Convex = Any
"""A convex solid in an engine's own form."""

Poses = Sequence[Any]
"""Rigid transforms in an engine's own form."""


class DistanceEngine(Protocol):
    """A library that measures distances. Points are (n, 3) [m] and triangles (m, 3) indices of points. A pose
    is that of the second shape in the frame of the first (first_from_second)."""

    def mesh(self, points: Array, triangles: npt.NDArray[np.int64]) -> Mesh:
        """Returns a mesh, open or closed, of any shape."""

    def convex(self, points: Array, triangles: npt.NDArray[np.int64]) -> Convex:
        """Returns a convex solid. All points must be vertices of its hull, and the triangles must face
        outwards."""

    def poses(self, first_from_second: Array) -> Poses:
        """Converts transforms (n, 4, 4) to poses of the engine."""

    def near(self, first: Mesh, second: Mesh, pose: Any, margin: float) -> bool:
        """Returns whether the distance between two surfaces is at most `margin` [m]."""

    def distance(self, first: Mesh, second: Mesh, pose: Any) -> float:
        """Returns the distance [m] between two surfaces; 0 or less if they intersect. It takes five times as
        long as `near`."""

    def depth(self, first: Convex, second: Convex, pose: Any) -> float:
        """Returns the penetration depth [m]: the shortest shift of the second solid after which both just
        touch. If they are apart, it is the negative distance."""


@functools.cache
def engine() -> DistanceEngine:
    """Returns the installed engine: Coal, else python-fcl."""
    # Each class imports its library itself, since only one of the two is installed.
    try:
        return _Coal()
    except ImportError:
        return _Fcl()


class _Coal:
    def __init__(self) -> None:
        import coal  # late: only one of the two libraries is installed

        self._coal = coal
        self._identity = coal.Transform3s.Identity()
        self._distance_request = coal.DistanceRequest()
        self._distance_request.enable_signed_distance = True
        self._distance_result = coal.DistanceResult()
        self._collision_request = coal.CollisionRequest()
        self._collision_result = coal.CollisionResult()

    def mesh(self, points: Array, triangles: npt.NDArray[np.int64]) -> Mesh:
        mesh = self._coal.BVHModelOBBRSS()
        mesh.beginModel(len(triangles), len(points))
        mesh.addVertices(np.asfortranarray(points))
        mesh.addTriangles(np.asfortranarray(triangles.astype(np.uint64)))
        mesh.endModel()
        return mesh

    def convex(self, points: Array, triangles: npt.NDArray[np.int64]) -> Convex:
        # Not `ConvexBase.convexHull`, which crashes on thin sets (coal 3.0.3).
        corners, faces = self._coal.StdVec_Vec3s(), self._coal.StdVec_Triangle()
        for point in points:
            corners.append(point)
        for a, b, c in triangles.tolist():
            faces.append(self._coal.Triangle(a, b, c))
        return self._coal.Convex(corners, faces)

    def poses(self, first_from_second: Array) -> Poses:
        return [self._coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in first_from_second]

    def near(self, first: Mesh, second: Mesh, pose: Any, margin: float) -> bool:
        self._collision_request.security_margin = margin
        self._collision_result.clear()
        return bool(
            self._coal.collide(
                first, self._identity, second, pose, self._collision_request, self._collision_result
            )
        )

    def distance(self, first: Mesh, second: Mesh, pose: Any) -> float:
        request, result = self._coal.DistanceRequest(), self._coal.DistanceResult()
        return float(self._coal.distance(first, self._identity, second, pose, request, result))

    def depth(self, first: Convex, second: Convex, pose: Any) -> float:
        self._distance_result.clear()
        return -float(
            self._coal.distance(
                first, self._identity, second, pose, self._distance_request, self._distance_result
            )
        )


class _Fcl:
    def __init__(self) -> None:
        import fcl  # late: only one of the two libraries is installed

        self._fcl = fcl
        self._identity = fcl.Transform()

    def mesh(self, points: Array, triangles: npt.NDArray[np.int64]) -> Mesh:
        mesh = self._fcl.BVHModel()
        mesh.beginModel(len(triangles), len(points))
        mesh.addSubModel(points, triangles)
        mesh.endModel()
        return mesh

    def convex(self, points: Array, triangles: npt.NDArray[np.int64]) -> Convex:
        faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
        return self._fcl.Convex(points, len(triangles), faces)

    def poses(self, first_from_second: Array) -> Poses:
        return [self._fcl.Transform(pose[:3, :3], pose[:3, 3]) for pose in first_from_second]

    def near(self, first: Mesh, second: Mesh, pose: Any, margin: float) -> bool:
        return self.distance(first, second, pose) <= margin

    def distance(self, first: Mesh, second: Mesh, pose: Any) -> float:
        objects = self._fcl.CollisionObject(first, self._identity), self._fcl.CollisionObject(second, pose)
        return float(self._fcl.distance(*objects, self._fcl.DistanceRequest(), self._fcl.DistanceResult()))

    def depth(self, first: Convex, second: Convex, pose: Any) -> float:
        objects = self._fcl.CollisionObject(first, self._identity), self._fcl.CollisionObject(second, pose)
        request = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)
        result = self._fcl.CollisionResult()
        if self._fcl.collide(*objects, request, result):
            return max(float(contact.penetration_depth) for contact in result.contacts)
        return -float(self._fcl.distance(*objects, self._fcl.DistanceRequest(), self._fcl.DistanceResult()))
