"""How far the colliders of a build are from what is seen, measured without any of the product's own code.

What the build wrote is read by MuJoCo: the pieces of each collider are its geoms, as it compiled them. What
is seen is read from the source by other libraries. Distances to a part are those to dense points on it,
mended by the triangles that hold the nearest of them; its inside is where its winding number by solid angles
is above ½; distances to a piece are exact.
"""

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
import trimesh
from scipy.spatial import ConvexHull, cKDTree

POINTS = 10_000
"""On a part, and on a collider."""

_CRACK = 5e-4
"""Points within this share of the diagonal ahead of a collider's surface count as on it."""

_REACH = 4.0
"""Points within this many tolerances of a part's box are compared with it first."""

_DENSE = 0.25
"""The spacing of the points that stand for a part, in tolerances."""


@dataclass(frozen=True)
class Fidelity:
    """How many tolerances a collider is off: by how much it stands out of its parts (p95, and the most), and
    by how much it leaves them bare at most; each by the tolerance of the part that is nearest."""

    protrusion_p95: float
    protrusion_max: float
    bareness_max: float

    @property
    def miss(self):
        """At most 1 where the collider is as near as it should be: 95 % of it may stand out by the tolerance,
        and all of it by three times as much."""
        return max(self.protrusion_p95, self.protrusion_max / 3, self.bareness_max)


_CUBES, _NEAR = 12, 2.5
"""Triangles count together in cubes so small, from so many times as far as they reach."""


def tolerance_of(part):
    """The default [m]."""
    return max(0.001, 0.015 * float(np.linalg.norm(np.ptp(part.vertices, axis=0))))


def fidelity(
    parts,
    pieces,
    tolerances=None,
    points=POINTS,
):
    """The fidelity of the pieces of a collider to its part or parts, in one frame; the tolerances [m] of the
    parts default to the product's. `points`: how many on either surface are looked at."""
    tolerances = tolerances or [tolerance_of(part) for part in parts]
    diagonal = float(np.linalg.norm(np.ptp(np.concatenate([part.vertices for part in parts]), axis=0)))
    outer = _outer(pieces, _CRACK * diagonal, points)
    solids = [_Solid(part, _DENSE * tolerance) for part, tolerance in zip(parts, tolerances, strict=True)]
    standing = _standing(solids, tolerances, outer)
    bare = 0.0
    for part, tolerance in zip(parts, tolerances, strict=True):
        seen, _ = trimesh.sample.sample_surface(part, points, seed=1)
        corners = np.unique(part.vertices, axis=0)
        step = max(1, len(corners) // points)
        far = _bareness(np.concatenate([seen, corners[::step]]), pieces)
        bare = max(bare, float(far.max()) / tolerance)
    return Fidelity(float(np.quantile(standing, 0.95)), float(standing.max()), bare)


def _standing(solids, tolerances, points):
    """(n,): how far points are outside of the nearest part, in its tolerances."""
    standing = np.full(len(points), np.inf)
    for reach in (_REACH, np.inf):  # first what is near, then what is near nothing
        for solid, tolerance in zip(solids, tolerances, strict=True):
            low, high = solid.bounds
            near = ((points >= low - reach * tolerance) & (points <= high + reach * tolerance)).all(axis=1)
            some = np.flatnonzero(near & ((standing > 0) if reach < np.inf else np.isinf(standing)))
            if len(some):
                far = solid.outside(points[some], tolerance / 4) / tolerance
                standing[some] = np.minimum(standing[some], far)
    return standing


def _outer(pieces, crack, count):
    """Points spread evenly over the outer surface of the pieces."""
    areas = np.array([piece.area for piece in pieces])
    kept = []
    for number, (piece, share) in enumerate(zip(pieces, areas / areas.sum(), strict=True)):
        points, normals = piece.samples(max(20, round(count * share)), number)
        ahead = points + crack * normals
        outer = np.ones(len(points), dtype=bool)
        for other in pieces:
            some = np.flatnonzero(outer)
            if other is not piece:
                buried = (other.planes(points[some]) <= 0) | (other.planes(ahead[some]) <= 0)
                outer[some[buried]] = False
        kept.append(points[outer])
    return np.concatenate(kept)


def _bareness(points, pieces):
    """How far points are outside of all pieces [m]; where that is little, at least how far."""
    far = np.min([piece.planes(points) for piece in pieces], axis=0)
    some = np.flatnonzero(far > 0)
    # The planes of a piece tell less than the distance off its edges.
    far[some] = np.min([piece.distance(points[some]) for piece in pieces], axis=0)
    return np.maximum(far, 0.0)


class Hull:
    """A convex collider: the hull of points (n, 3).

    `planes`: (n,), the distance [m] outside of it, or less, at most 0 inside; `distance`: (n,), the distance
    [m] outside of it, 0 inside; `samples`: points (n, 3) spread evenly over its surface, and the outward
    normals.
    """

    def __init__(self, points):
        hull = ConvexHull(points)
        self.area = float(hull.area)
        self._normals, self._offsets = hull.equations[:, :3], hull.equations[:, 3]
        self._corners = hull.points[hull.simplices]

    def planes(self, points):
        heights = np.full(len(points), -np.inf)
        for normal, offset in zip(self._normals, self._offsets, strict=True):
            np.maximum(heights, points @ normal + offset, out=heights)
        return heights

    def distance(self, points):
        beyond = self.planes(points)
        some = np.flatnonzero(beyond > 0)
        gaps = np.full(len(some), np.inf)
        for corners in self._corners:
            gaps = np.minimum(gaps, to_triangles(points[some], np.broadcast_to(corners, (len(some), 3, 3))))
        result = np.zeros(len(points))
        result[some] = gaps
        return result

    def samples(self, count, seed):
        random = np.random.default_rng(seed)
        a, b, c = np.moveaxis(self._corners, 1, 0)
        sizes = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        which = random.choice(len(sizes), count, p=sizes / sizes.sum())
        u, v = random.random((2, count, 1))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        a, b, c = a[which], b[which], c[which]
        return a + u * (b - a) + v * (c - a), self._normals[which]


class Round:
    """A sphere, a capsule or a cylinder about the third axis of its pose, as `Hull`: `half` [m] of the height
    of what is straight of it, `ends` whether half a sphere is at each end."""

    def __init__(self, pose, radius, half, ends):
        self._pose, self._radius, self._half, self._ends = pose, radius, half, ends
        caps = 4 * np.pi * radius**2 if ends else 2 * np.pi * radius**2
        self.area = 4 * np.pi * radius * half + caps

    def _beyond(self, points):
        local = (points - self._pose[:3, 3]) @ self._pose[:3, :3]
        aside, along = np.hypot(local[:, 0], local[:, 1]), np.abs(local[:, 2]) - self._half
        if self._ends:
            away = np.hypot(aside, np.maximum(along, 0.0)) - self._radius
            return away, np.maximum(away, 0.0)
        beyond = np.stack([aside - self._radius, along])
        return beyond.max(axis=0), np.hypot(*np.maximum(beyond, 0.0))

    def planes(self, points):
        return self._beyond(points)[0]

    def distance(self, points):
        return self._beyond(points)[1]

    def samples(self, count, seed):
        random = np.random.default_rng(seed)
        turn = random.uniform(0, 2 * np.pi, count)
        around = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        straight = random.random(count) < 4 * np.pi * self._radius * self._half / self.area
        sign = random.choice([-1.0, 1.0], count)
        if self._ends:
            height = np.where(straight, 0.0, random.random(count))  # Archimedes: even on a sphere
            width = np.sqrt(1 - height**2)
            normals = np.column_stack([around * width[:, None], sign * height])
            local = normals * self._radius
            local[:, 2] += np.where(straight, random.uniform(-1, 1, count), sign) * self._half
        else:
            aside = np.where(straight, 1.0, np.sqrt(random.random(count))) * self._radius
            level = np.where(straight, random.uniform(-1, 1, count), sign) * self._half
            local = np.column_stack([around * aside[:, None], level])
            flat = np.column_stack([np.zeros((count, 2)), sign])
            normals = np.where(straight[:, None], np.column_stack([around, np.zeros(count)]), flat)
        turned = self._pose[:3, :3].T
        return local @ turned + self._pose[:3, 3], normals @ turned


def pieces_of(model):
    """The colliders of a robot by body, in the order of the geoms, in the frame of the body: all but what is
    only seen."""
    hulls = {}
    for geom in np.flatnonzero((model.geom_contype != 0) | (model.geom_conaffinity != 0)):
        if model.geom_bodyid[geom] == 0 and model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
            continue
        hulls.setdefault(model.body(model.geom_bodyid[geom]).name, []).append(_piece(model, int(geom)))
    return hulls


def pose_of(model, geom):
    """The pose (4, 4) of a geom in its body."""
    pose = np.eye(4)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    pose[:3, :3], pose[:3, 3] = turn.reshape(3, 3), model.geom_pos[geom]
    return pose


def mesh_of(model, geom):
    """The mesh of a geom in the frame of its body."""
    mesh = model.geom_dataid[geom]
    points, faces = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
    vertices = model.mesh_vert[points : points + model.mesh_vertnum[mesh]].astype(float)
    triangles = model.mesh_face[faces : faces + model.mesh_facenum[mesh]]
    pose = pose_of(model, geom)
    return trimesh.Trimesh(vertices @ pose[:3, :3].T + pose[:3, 3], triangles, process=False)


def _piece(model, geom):
    kind, size, pose = mujoco.mjtGeom(model.geom_type[geom]), model.geom_size[geom], pose_of(model, geom)
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        return Hull(mesh_of(model, geom).vertices)
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        corners = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T * size
        return Hull(corners @ pose[:3, :3].T + pose[:3, 3])
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return Round(pose, size[0], 0.0, ends=True)
    return Round(pose, size[0], size[1], ends=kind == mujoco.mjtGeom.mjGEOM_CAPSULE)


class _Solid:
    """A part, closed or not. `spacing` [m] of the points that stand for it."""

    def __init__(self, mesh, spacing):
        self._corners = np.asarray(mesh.triangles, dtype=float)
        count = int(np.clip(mesh.area / spacing**2, 20_000, 200_000))
        self._points, self._owners = trimesh.sample.sample_surface(mesh, count, seed=2)

        self.bounds = mesh.bounds

    @cached_property
    def _tree(self):
        return cKDTree(self._points)

    def outside(self, points, least):
        """How far points (n, 3) are outside [m]; less than `least` may be said of what is inside."""
        far, nearest = self._tree.query(points, 8)
        some = np.flatnonzero(far[:, 0] > least)
        owners = self._owners[nearest[some]]
        exact = [to_triangles(points[some], self._corners[owner]) for owner in owners.T]
        result = far[:, 0]
        result[some] = np.where(self._around(points[some]) > 0.5, 0.0, np.min(exact, axis=0))
        return result

    def _around(self, points):
        """The winding number of points: the sum of the solid angles of all triangles (Van Oosterom and
        Strackee, 1983), those far away together as one dipole (Barill et al., "Fast winding numbers for soups
        and clouds", 2018)."""
        angles = np.zeros(len(points))
        for corners in self._clusters:
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
            sizes = np.linalg.norm(normals, axis=1)
            middle = np.average(corners.mean(axis=1), axis=0, weights=sizes + 1e-30)
            reach = np.linalg.norm(corners - middle, axis=2).max()
            away = middle - points
            far = np.linalg.norm(away, axis=1)
            near = far < _NEAR * reach
            angles[~near] += away[~near] @ normals.sum(axis=0) / far[~near] ** 3 / (4 * np.pi)
            angles[near] += solid_angles(points[near], corners) / (4 * np.pi)
        return angles

    @cached_property
    def _clusters(self):
        """The triangles by the cubes of a grid that they are in."""
        middles = self._corners.mean(axis=1)
        side = np.ptp(middles, axis=0).max() / _CUBES or 1.0
        _, cubes = np.unique(np.floor(middles / side).astype(int), axis=0, return_inverse=True)
        order = np.argsort(cubes.ravel(), kind="stable")
        return np.split(self._corners[order], np.flatnonzero(np.diff(cubes.ravel()[order])) + 1)


def solid_angles(points, corners):
    """(n,): the sum of the solid angles of triangles (m, 3, 3) from points (n, 3)."""
    angles = np.zeros(len(points))
    for some in np.array_split(np.arange(len(points)), 1 + len(points) * len(corners) // 1_000_000):
        a, b, c = (corners[None, :, k] - points[some, None] for k in range(3))
        p, q, r = (np.sqrt(np.einsum("ijk,ijk->ij", corner, corner)) for corner in (a, b, c))
        volume = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
        ab, bc, ca = (np.einsum("ijk,ijk->ij", u, v) for u, v in ((a, b), (b, c), (c, a)))
        angles[some] = 2 * np.arctan2(volume, p * q * r + ab * r + bc * p + ca * q).sum(axis=1)
    return angles


def to_triangles(points, corners):
    """(n,): the distance [m] of each point (n, 3) from its triangle (n, 3, 3): to the plane where the point
    is above the triangle, else to the nearest of the edges."""
    a, b, c = np.moveaxis(corners, 1, 0)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    above = length > 0
    edges = np.full(len(points), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        along, off = end - start, points - start
        square = (along * along).sum(axis=1)
        share = np.divide((off * along).sum(axis=1), square, out=np.zeros(len(off)), where=square > 0)
        edges = np.minimum(edges, np.linalg.norm(off - np.clip(share, 0, 1)[:, None] * along, axis=1))
        above &= (np.cross(along, off) * normal).sum(axis=1) >= 0
    height = np.abs(((points - a) * normal).sum(axis=1)) / np.where(length > 0, length, 1.0)
    return np.where(above, height, edges)
