"""The shapes of a compiled model's bodies, measured: how far they reach, and how far points are outside them.

All is in the frame of the body. A mesh that collides is its convex hull, as it is to MuJoCo.
"""

import math
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.poses import placed

GEOM = mujoco.mjtGeom
SPHERE, CAPSULE, CYLINDER = int(GEOM.mjGEOM_SPHERE), int(GEOM.mjGEOM_CAPSULE), int(GEOM.mjGEOM_CYLINDER)
BOX, ELLIPSOID, MESH = int(GEOM.mjGEOM_BOX), int(GEOM.mjGEOM_ELLIPSOID), int(GEOM.mjGEOM_MESH)

NO_COLLIDER = ("none", "visual")
"""Makers of colliders that make none."""

MEASURED = (SPHERE, CAPSULE, CYLINDER, BOX, ELLIPSOID, MESH)
"""The kinds of geoms that are measured: not planes, height fields and fields of distances."""


def seen_and_solid(model: Any) -> dict[int, tuple[list[int], list[int]]]:
    """By body: the geoms that are only seen, and those that collide, in their order. What is neither is no
    shape of a robot: it has no material, and a colour that is not seen."""
    found: dict[int, tuple[list[int], list[int]]] = {}
    for geom in range(model.ngeom):
        hidden = model.geom_rgba[geom][3] == 0 and model.geom_matid[geom] < 0
        if model.geom_type[geom] in MEASURED:
            collides = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
            if collides or not hidden:
                found.setdefault(int(model.geom_bodyid[geom]), ([], []))[collides].append(geom)
    return found


def named_geom(model: Any, geom: int, link: str = "") -> str:
    """A geom as an element of its file; one without a name by its mesh, else by its link or body."""
    name = model.geom(geom).name
    if name:
        return named("geom", name)
    mesh = int(model.geom_dataid[geom])
    if mesh >= 0 and model.geom_type[geom] == MESH:
        return named("geom mesh", model.mesh(mesh).name)
    return f"geom of {named('body', link or model.body(int(model.geom_bodyid[geom])).name)}"


def directions(number: int) -> Array:
    """Unit vectors (number, 3), spread evenly over the sphere (Fibonacci's lattice)."""
    steps = np.arange(number) + 0.5
    z = 1.0 - 2.0 * steps / number
    turn = steps * math.pi * (3.0 - math.sqrt(5.0))
    flat = np.sqrt(1.0 - z * z)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])


def reach(model: Any, geoms: Sequence[int], along: Array) -> Array:
    """How far the geoms reach along each unit vector (M, 3) from the origin of their body [m] (M,): the
    support function of what they are together."""
    found = np.full(len(along), -np.inf)
    for geom in geoms:
        np.maximum(found, _reach(model, geom, along), out=found)
    return found


def _reach(model: Any, geom: int, along: Array) -> Array:
    kind, size = model.geom_type[geom], model.geom_size[geom]
    pose = placed(model.geom_quat[geom], model.geom_pos[geom])
    own, origin = along @ pose[:3, :3], along @ pose[:3, 3]
    if kind == MESH:
        return np.asarray(origin + (vertices(model, geom) @ own.T).max(axis=0))
    if kind == BOX:
        return np.asarray(origin + np.abs(own) @ size)
    if kind == ELLIPSOID:
        return np.asarray(origin + np.linalg.norm(own * size, axis=1))
    if kind == CYLINDER:
        return np.asarray(origin + size[0] * np.hypot(own[:, 0], own[:, 1]) + size[1] * np.abs(own[:, 2]))
    return np.asarray(origin + size[0] + (size[1] * np.abs(own[:, 2]) if kind == CAPSULE else 0.0))


def vertices(model: Any, geom: int) -> Array:
    """The vertices (N, 3) of a mesh, in the geom's own frame."""
    mesh = int(model.geom_dataid[geom])
    first = int(model.mesh_vertadr[mesh])
    return np.asarray(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])], float)


def surface_points(model: Any, geoms: Sequence[int], number: int) -> Array:
    """Up to `number` points (N, 3) of the surfaces of the geoms, spread evenly over the list of their
    vertices and the centres of their faces; of a shape that is no mesh those that are foremost in some
    direction."""
    found = [np.empty((0, 3))]
    for geom in geoms:
        pose = placed(model.geom_quat[geom], model.geom_pos[geom])
        own = _corners(model, geom)
        found.append(own @ pose[:3, :3].T + pose[:3, 3])
    points = np.concatenate(found)
    chosen = np.linspace(0, len(points) - 1, min(number, len(points))).astype(int)
    return np.asarray(points[chosen])


def _corners(model: Any, geom: int) -> Array:
    if model.geom_type[geom] == MESH:
        mesh = int(model.geom_dataid[geom])
        first, corners = int(model.mesh_faceadr[mesh]), vertices(model, geom)
        faces = model.mesh_face[first : first + int(model.mesh_facenum[mesh])]
        return np.concatenate([corners, corners[faces].mean(axis=1)])
    kind, size, along = model.geom_type[geom], model.geom_size[geom], directions(64)
    if kind == BOX:
        signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
        return np.asarray(signs * size)
    if kind == ELLIPSOID:
        return np.asarray(along * size**2 / np.linalg.norm(along * size, axis=1, keepdims=True))
    half = 0.0 if kind == SPHERE else size[1]
    ends = np.column_stack([np.zeros((len(along), 2)), half * np.sign(along[:, 2])])
    if kind == CYLINDER:
        rim = along[:, :2] / np.linalg.norm(along[:, :2], axis=1, keepdims=True)
        return np.asarray(ends + size[0] * np.column_stack([rim, np.zeros(len(along))]))
    return np.asarray(ends + size[0] * along)


def outside(model: Any, geoms: Sequence[int], points: Array) -> Array:
    """How far points (N, 3) are outside the nearest of the geoms [m] (N,), 0 within one; of meshes and
    ellipsoids at least so far."""
    found = np.full(len(points), np.inf)
    for geom in geoms:
        pose = placed(model.geom_quat[geom], model.geom_pos[geom])
        own = (points - pose[:3, 3]) @ pose[:3, :3]
        np.minimum(found, _outside(model, geom, own), out=found)
    return np.asarray(np.maximum(found, 0.0))


def _outside(model: Any, geom: int, points: Array) -> Array:
    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == MESH:
        return _outside_hull(model, geom, points)
    if kind == BOX:
        return np.asarray(np.linalg.norm(np.maximum(np.abs(points) - size, 0.0), axis=1))
    if kind == ELLIPSOID:
        return np.asarray((np.linalg.norm(points / size, axis=1) - 1.0) * size.min())
    along = np.zeros(len(points)) if kind == SPHERE else np.abs(points[:, 2]) - size[1]
    across = np.hypot(points[:, 0], points[:, 1])
    if kind == CYLINDER:
        return np.asarray(np.hypot(np.maximum(across - size[0], 0.0), np.maximum(along, 0.0)))
    beyond = np.abs(points[:, 2]) if kind == SPHERE else np.maximum(along, 0.0)
    return np.asarray(np.hypot(across, beyond) - size[0])


def _outside_hull(model: Any, geom: int, points: Array) -> Array:
    """By the planes of the hull's faces; by its box where MuJoCo made no hull."""
    mesh, corners = int(model.geom_dataid[geom]), vertices(model, geom)
    first, number = int(model.mesh_polyadr[mesh]), int(model.mesh_polynum[mesh])
    if not number:
        middle, half = (corners.max(0) + corners.min(0)) / 2, (corners.max(0) - corners.min(0)) / 2
        return np.asarray(np.linalg.norm(np.maximum(np.abs(points - middle) - half, 0.0), axis=1))
    sizes = model.mesh_polyvertnum[first : first + number]
    start = int(model.mesh_polyvertadr[first])
    rounds = corners[model.mesh_polyvert[start : start + int(sizes.sum())]]
    normals, offsets = _planes(rounds, np.cumsum(sizes) - sizes)
    return np.asarray((points @ normals.T - offsets).max(axis=1))


def _planes(corners: Array, starts: npt.NDArray[np.integer]) -> tuple[Array, Array]:
    """The unit normals (P, 3) of polygons and how far their planes are from the origin [m] (P,). `corners`
    (N, 3) has the polygons one after the other, `starts` (P,) the first corner of each. A normal is of the
    whole polygon (Newell's formula): MuJoCo before 4.0 has that of three corners, which may be one sliver."""
    nexts = np.arange(len(corners)) + 1
    lasts = np.append(starts[1:], len(corners)) - 1
    nexts[lasts] = starts
    areas = np.add.reduceat(np.cross(corners, corners[nexts]), starts)
    normals = areas / np.maximum(np.linalg.norm(areas, axis=1, keepdims=True), np.finfo(float).tiny)
    middles = np.add.reduceat(corners, starts) / np.diff(np.append(starts, len(corners)))[:, None]
    return normals, (normals * middles).sum(axis=1)


def area(model: Any, geom: int) -> float:
    """The area of a mesh [m²]."""
    mesh = int(model.geom_dataid[geom])
    first = int(model.mesh_faceadr[mesh])
    a, b, c = vertices(model, geom)[model.mesh_face[first : first + int(model.mesh_facenum[mesh])]].swapaxes(
        0, 1
    )
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0


def asked_bare(compiled: CompiledModel, body: str) -> bool:
    """Whether the configuration gives the links of a body no collider; where that is known."""
    names = {name for name, (holder, _) in compiled.held.items() if holder == body} or {body}
    figures = compiled.geometry.colliders if compiled.geometry else ()
    own = [one for one in figures if one.link in names]
    return bool(own) and all(one.maker in NO_COLLIDER for one in own)
