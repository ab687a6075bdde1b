"""Whether two meshes are near each other, and how deep two convex solids are in each other, at many poses.

Coal answers both (the BVH and GJK/EPA library of Pinocchio); where it has no wheel, as on Windows,
python-fcl does. Their answers are the same on the robots that they were compared on, and manifold3d's
`min_gap` takes a hundred times as long.
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
"""Triangles as an engine keeps them."""

Convex = Any
"""A convex solid as an engine keeps it."""

Poses = Sequence[Any]
"""Rigid transforms as an engine keeps them."""


class DistanceEngine(Protocol):
    """What answers. All points are (n, 3) [m], triangles (m, 3); poses say where the other is in the frame
    of the one (one_from_other)."""

    def mesh(self, points: Array, triangles: npt.NDArray[np.int64]) -> Mesh:
        """A mesh, open or closed, of any shape."""

    def convex(self, points: Array, triangles: npt.NDArray[np.int64]) -> Convex:
        """The convex hull of points that are all its corners; triangles face outwards."""

    def poses(self, one_from_other: Array) -> Poses:
        """Transforms (n, 4, 4)."""

    def near(self, one: Mesh, other: Mesh, pose: Any, margin: float) -> bool:
        """Whether two surfaces are within `margin` [m] of each other."""

    def apart(self, one: Mesh, other: Mesh, pose: Any) -> float:
        """How far apart [m] two surfaces are, at most 0 where they cut. It takes five times as long."""

    def depth(self, one: Convex, other: Convex, pose: Any) -> float:
        """How far [m] the other has to move until both only touch; less than 0: how far they are apart."""


@functools.cache
def engine() -> DistanceEngine:
    """The engine that is installed; coal where both are."""
    try:
        return _Coal()
    except ImportError:
        return _Fcl()


class _Coal:
    def __init__(self) -> None:
        # Late: one of the two is installed.
        import coal

        self._coal = coal
        self._here = coal.Transform3s.Identity()
        self._asked = coal.DistanceRequest()
        self._asked.enable_signed_distance = True
        self._found = coal.DistanceResult()
        self._near = coal.CollisionRequest()
        self._nearer = coal.CollisionResult()

    def mesh(self, points: Array, triangles: npt.NDArray[np.int64]) -> Mesh:
        made = self._coal.BVHModelOBBRSS()
        made.beginModel(len(triangles), len(points))
        made.addVertices(np.asfortranarray(points))
        made.addTriangles(np.asfortranarray(triangles.astype(np.uint64)))
        made.endModel()
        return made

    def convex(self, points: Array, triangles: npt.NDArray[np.int64]) -> Convex:
        # Not `ConvexBase.convexHull`, which crashes on thin sets (coal 3.0.3).
        corners, faces = self._coal.StdVec_Vec3s(), self._coal.StdVec_Triangle()
        for point in points:
            corners.append(point)
        for a, b, c in triangles.tolist():
            faces.append(self._coal.Triangle(a, b, c))
        return self._coal.Convex(corners, faces)

    def poses(self, one_from_other: Array) -> Poses:
        return [self._coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in one_from_other]

    def near(self, one: Mesh, other: Mesh, pose: Any, margin: float) -> bool:
        self._near.security_margin = margin
        self._nearer.clear()
        return bool(self._coal.collide(one, self._here, other, pose, self._near, self._nearer))

    def apart(self, one: Mesh, other: Mesh, pose: Any) -> float:
        asked, found = self._coal.DistanceRequest(), self._coal.DistanceResult()
        return float(self._coal.distance(one, self._here, other, pose, asked, found))

    def depth(self, one: Convex, other: Convex, pose: Any) -> float:
        self._found.clear()
        return -float(self._coal.distance(one, self._here, other, pose, self._asked, self._found))


class _Fcl:
    def __init__(self) -> None:
        # Late: one of the two is installed.
        import fcl

        self._fcl = fcl
        self._here = fcl.Transform()

    def mesh(self, points: Array, triangles: npt.NDArray[np.int64]) -> Mesh:
        made = self._fcl.BVHModel()
        made.beginModel(len(triangles), len(points))
        made.addSubModel(points, triangles)
        made.endModel()
        return made

    def convex(self, points: Array, triangles: npt.NDArray[np.int64]) -> Convex:
        faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
        return self._fcl.Convex(points, len(triangles), faces)

    def poses(self, one_from_other: Array) -> Poses:
        return [self._fcl.Transform(pose[:3, :3], pose[:3, 3]) for pose in one_from_other]

    def near(self, one: Mesh, other: Mesh, pose: Any, margin: float) -> bool:
        return self.apart(one, other, pose) <= margin

    def apart(self, one: Mesh, other: Mesh, pose: Any) -> float:
        ends = self._fcl.CollisionObject(one, self._here), self._fcl.CollisionObject(other, pose)
        return float(self._fcl.distance(*ends, self._fcl.DistanceRequest(), self._fcl.DistanceResult()))

    def depth(self, one: Convex, other: Convex, pose: Any) -> float:
        ends = self._fcl.CollisionObject(one, self._here), self._fcl.CollisionObject(other, pose)
        asked = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)
        found = self._fcl.CollisionResult()
        if self._fcl.collide(*ends, asked, found):
            return max(float(one.penetration_depth) for one in found.contacts)
        return -float(self._fcl.distance(*ends, self._fcl.DistanceRequest(), self._fcl.DistanceResult()))
