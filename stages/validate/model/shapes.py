"""Measures the shapes of a compiled model's bodies: their reach, and the distances of points outside them.

All lengths are in the frame of the body. A colliding mesh is its convex hull, as in MuJoCo.
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
"""Makers of colliders for links without a collider."""

MEASURED = (SPHERE, CAPSULE, CYLINDER, BOX, ELLIPSOID, MESH)
"""The kinds of geoms that are measured: all but planes, height fields and signed distance fields."""


def seen_and_solid(model: Any) -> dict[int, tuple[list[int], list[int]]]:
    """Maps each body to its purely visual geoms and its colliding geoms, in their order. Transparent geoms
    without contact and material are neither: they are no shapes of the robot."""
    by_body: dict[int, tuple[list[int], list[int]]] = {}
    for geom in range(model.ngeom):
        hidden = model.geom_rgba[geom][3] == 0 and model.geom_matid[geom] < 0
        if model.geom_type[geom] in MEASURED:
            collides = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
            if collides or not hidden:
                by_body.setdefault(int(model.geom_bodyid[geom]), ([], []))[collides].append(geom)
    return by_body


def named_geom(model: Any, geom: int, link: str = "") -> str:
    """Returns the title of a geom in findings. A geom without a name is called by its mesh, else by its link
    or body."""
    name = model.geom(geom).name
    if name:
        return named("geom", name)
    mesh = int(model.geom_dataid[geom])
    if mesh >= 0 and model.geom_type[geom] == MESH:
        return named("geom mesh", model.mesh(mesh).name)
    return f"geom of {named('body', link or model.body(int(model.geom_bodyid[geom])).name)}"


def directions(number: int) -> Array:
    """Returns unit vectors (number, 3), spread evenly over the sphere (Fibonacci's lattice)."""
    steps = np.arange(number) + 0.5
    z = 1.0 - 2.0 * steps / number
    # Steps by the golden angle, at even heights: bands of equal height have equal area on a sphere.
    azimuth = steps * math.pi * (3.0 - math.sqrt(5.0))
    flat = np.sqrt(1.0 - z * z)
    return np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), z])


def reach(model: Any, geoms: Sequence[int], along: Array) -> Array:
    """Returns the reach [m] (M,) of the geoms along each unit vector (M, 3), from the origin of their body:
    the support function of their union."""
    reaches = np.full(len(along), -np.inf)
    for geom in geoms:
        np.maximum(reaches, _reach(model, geom, along), out=reaches)
    return reaches


def _reach(model: Any, geom: int, along: Array) -> Array:
    """Returns the support function of a geom: the largest product of its points with each direction."""
    kind, size = model.geom_type[geom], model.geom_size[geom]
    pose = placed(model.geom_quat[geom], model.geom_pos[geom])
    local, origin = along @ pose[:3, :3], along @ pose[:3, 3]
    if kind == MESH:
        return np.asarray(origin + (vertices(model, geom) @ local.T).max(axis=0))
    if kind == BOX:
        return np.asarray(origin + np.abs(local) @ size)
    if kind == ELLIPSOID:
        return np.asarray(origin + np.linalg.norm(local * size, axis=1))
    if kind == CYLINDER:
        return np.asarray(
            origin + size[0] * np.hypot(local[:, 0], local[:, 1]) + size[1] * np.abs(local[:, 2])
        )
    return np.asarray(origin + size[0] + (size[1] * np.abs(local[:, 2]) if kind == CAPSULE else 0.0))


def vertices(model: Any, geom: int) -> Array:
    """Returns the vertices (N, 3) of a mesh, in the geom's own frame."""
    mesh = int(model.geom_dataid[geom])
    first = int(model.mesh_vertadr[mesh])
    return np.asarray(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])], float)


def surface_points(model: Any, geoms: Sequence[int], number: int) -> Array:
    """Returns up to `number` points (N, 3) of the surfaces of the geoms, sampled evenly from the list of the
    meshes' vertices and face centres, and of the primitives' outermost points in some directions."""
    clouds = [np.empty((0, 3))]
    for geom in geoms:
        pose = placed(model.geom_quat[geom], model.geom_pos[geom])
        corners = _sample_points(model, geom)
        clouds.append(corners @ pose[:3, :3].T + pose[:3, 3])
    points = np.concatenate(clouds)
    indices = np.linspace(0, len(points) - 1, min(number, len(points))).astype(int)
    return np.asarray(points[indices])


def _sample_points(model: Any, geom: int) -> Array:
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
        # The points whose normals are the directions.
        return np.asarray(along * size**2 / np.linalg.norm(along * size, axis=1, keepdims=True))
    half = 0.0 if kind == SPHERE else size[1]
    ends = np.column_stack([np.zeros((len(along), 2)), half * np.sign(along[:, 2])])
    if kind == CYLINDER:
        rim = along[:, :2] / np.linalg.norm(along[:, :2], axis=1, keepdims=True)
        return np.asarray(ends + size[0] * np.column_stack([rim, np.zeros(len(along))]))
    return np.asarray(ends + size[0] * along)


def outside(model: Any, geoms: Sequence[int], points: Array) -> Array:
    """Returns the distance [m] (N,) of points (N, 3) from the nearest geom, 0 within a geom. For meshes and
    ellipsoids it is a lower bound."""
    distances = np.full(len(points), np.inf)
    for geom in geoms:
        pose = placed(model.geom_quat[geom], model.geom_pos[geom])
        local = (points - pose[:3, 3]) @ pose[:3, :3]
        np.minimum(distances, _outside(model, geom, local), out=distances)
    return np.asarray(np.maximum(distances, 0.0))


def _outside(model: Any, geom: int, points: Array) -> Array:
    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == MESH:
        return _outside_hull(model, geom, points)
    if kind == BOX:
        return np.asarray(np.linalg.norm(np.maximum(np.abs(points) - size, 0.0), axis=1))
    if kind == ELLIPSOID:
        # The scale along the shortest axis makes it a lower bound of the distance.
        return np.asarray((np.linalg.norm(points / size, axis=1) - 1.0) * size.min())
    along = np.zeros(len(points)) if kind == SPHERE else np.abs(points[:, 2]) - size[1]
    across = np.hypot(points[:, 0], points[:, 1])
    if kind == CYLINDER:
        return np.asarray(np.hypot(np.maximum(across - size[0], 0.0), np.maximum(along, 0.0)))
    beyond = np.abs(points[:, 2]) if kind == SPHERE else np.maximum(along, 0.0)
    return np.asarray(np.hypot(across, beyond) - size[0])


def _outside_hull(model: Any, geom: int, points: Array) -> Array:
    """Returns the distance [m] (N,) from the planes of the hull's faces, or from the box if MuJoCo made no
    hull."""
    mesh, corners = int(model.geom_dataid[geom]), vertices(model, geom)
    first, number = int(model.mesh_polyadr[mesh]), int(model.mesh_polynum[mesh])
    if not number:
        middle, half = (corners.max(0) + corners.min(0)) / 2, (corners.max(0) - corners.min(0)) / 2
        return np.asarray(np.linalg.norm(np.maximum(np.abs(points - middle) - half, 0.0), axis=1))
    sizes = model.mesh_polyvertnum[first : first + number]
    start = int(model.mesh_polyvertadr[first])
    polygon_corners = corners[model.mesh_polyvert[start : start + int(sizes.sum())]]
    normals, offsets = _planes(polygon_corners, np.cumsum(sizes) - sizes)
    return np.asarray((points @ normals.T - offsets).max(axis=1))


def _planes(corners: Array, starts: npt.NDArray[np.integer]) -> tuple[Array, Array]:
    """Returns the unit normals (P, 3) of polygons and the distances [m] (P,) of their planes from the origin.

    `corners` (N, 3) has the polygons one after the other, `starts` (P,) the first corner of each. The normal
    is computed over the whole polygon (Newell's formula): MuJoCo before 4.0 takes the normal of three
    corners, which may be a sliver.
    """
    # The next corner of each corner; after the last corner of a polygon comes its first.
    next_indices = np.arange(len(corners)) + 1
    last_indices = np.append(starts[1:], len(corners)) - 1
    next_indices[last_indices] = starts
    areas = np.add.reduceat(np.cross(corners, corners[next_indices]), starts)
    normals = areas / np.maximum(np.linalg.norm(areas, axis=1, keepdims=True), np.finfo(float).tiny)
    middles = np.add.reduceat(corners, starts) / np.diff(np.append(starts, len(corners)))[:, None]
    return normals, (normals * middles).sum(axis=1)


def area(model: Any, geom: int) -> float:
    """Returns the area of a mesh [m²]."""
    mesh = int(model.geom_dataid[geom])
    first = int(model.mesh_faceadr[mesh])
    a, b, c = vertices(model, geom)[model.mesh_face[first : first + int(model.mesh_facenum[mesh])]].swapaxes(
        0, 1
    )
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0


def is_bare_by_choice(compiled: CompiledModel, body: str) -> bool:
    """Tells whether the configuration gives the links of a body no collider, if that is known."""
    names = {name for name, (holder, _) in compiled.held.items() if holder == body} or {body}
    figures = compiled.geometry.colliders if compiled.geometry else ()
    body_figures = [figure for figure in figures if figure.link in names]
    return bool(body_figures) and all(figure.maker in NO_COLLIDER for figure in body_figures)
