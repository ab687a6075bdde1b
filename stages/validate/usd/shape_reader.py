"""Reads the visual shapes and colliders of a USD's bodies, in metres."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Usd, UsdGeom, UsdPhysics

from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.usd.look_reader import ReadUsdLook, look_of
from linkwright.stages.validate.usd.prim_reader import filtered_paths, schemas

KIND_BY_TYPE = {
    "Cube": "box",
    "Sphere": "sphere",
    "Cylinder": "cylinder",
    "Capsule": "capsule",
    "Mesh": "mesh",
}
"""Type of a prim → kind of shape."""


_EQUAL_SCALES = {"sphere": 3, "cylinder": 2, "capsule": 3}
"""Kind of shape → the number of axes, from x, along which its scale must be the same: else it is another
shape."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdShape:
    """A shape of a body. Bounds and corners of a mesh are in the body's frame."""

    name: str
    kind: str
    collides: bool
    """Whether the shape is a collider: it has UsdPhysics's schema, or is a guide, which is not drawn."""

    path: str
    """The path of the prim."""

    filtered: frozenset[str]
    """The paths of the prims with which the shape itself does not collide."""

    flaws: tuple[tuple[str, str, str], ...]
    """(attribute, actual, expected) for schemas and attributes that keep the shape from colliding or from
    being convex, or that change its surface."""

    size: tuple[float, ...]
    """The size [m] as in `model.Primitive`; () for a mesh."""

    body_from_shape: Array
    """The pose (4, 4), without scale."""

    bounds: tuple[float, ...]
    """The bounds (6,) [m] of a mesh: the least x, y and z, then the largest; () without points."""

    corners: npt.NDArray[np.float32] | None
    """The corners (n, 3, 3) [m] of a mesh's triangles; None if the faces are not triangles of its points."""

    texcoords: npt.NDArray[np.float32] | None
    """The texture coordinates (n, 3, 2) of the corners; None unless each corner has them."""

    look: ReadUsdLook
    """The look and the friction."""


def shapes_of(body: Any) -> Iterator[ReadUsdShape]:
    """Yields the shapes at and below a prim, in their order, also those in instances."""
    cache = UsdGeom.XformCache()
    body_from_world = inverse(np.array(cache.GetLocalToWorldTransform(body)).T)
    for prim in Usd.PrimRange(body, Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdGeom.Gprim):
            yield _shape(prim, body_from_world @ np.array(cache.GetLocalToWorldTransform(prim)).T)


def _shape(prim: Any, body_from_prim: Array) -> ReadUsdShape:
    kind = KIND_BY_TYPE.get(prim.GetTypeName(), prim.GetTypeName())
    has_collision_schema = prim.HasAPI(UsdPhysics.CollisionAPI)
    is_guide = UsdGeom.Imageable(prim).ComputePurpose() == UsdGeom.Tokens.guide
    scale = np.linalg.norm(body_from_prim[:3, :3], axis=0)
    body_from_shape = body_from_prim.copy()
    body_from_shape[:3, :3] /= np.where(scale > 0, scale, 1.0)
    collides = has_collision_schema or is_guide
    flaws = list(_surface_flaws(prim, kind, scale))
    if collides:
        flaws += _collider_flaws(prim, kind, has_collision_schema, is_guide)
    points = _points(prim, body_from_prim)
    corners = _corners(prim, points)
    return ReadUsdShape(
        prim.GetName(),
        kind,
        collides,
        str(prim.GetPath()),
        frozenset(map(str, filtered_paths(prim))),
        tuple(flaws),
        _size(prim, kind, scale),
        body_from_shape,
        (*map(float, points.min(axis=0)), *map(float, points.max(axis=0))) if len(points) else (),
        corners,
        None if corners is None else _texcoords(prim, len(corners)),
        look_of(prim),
    )


def _surface_flaws(prim: Any, kind: str, scale: Array) -> Iterator[tuple[str, str, str]]:
    """Yields attributes that would change the surface of a shape, although its size or its points are
    right."""
    if kind in _EQUAL_SCALES and not np.allclose(scale[: _EQUAL_SCALES[kind]], scale[0], rtol=1e-6, atol=0.0):
        yield "xformOp:scale", " ".join(f"{factor:g}" for factor in scale), "the same along all axes"
    if kind in ("cylinder", "capsule"):
        axis = str(prim.GetAttribute("axis").Get())
        if axis != "Z":
            yield "axis", axis, "Z"
    if kind != "mesh":
        return
    mesh = UsdGeom.Mesh(prim)
    conventions = mesh.GetSubdivisionSchemeAttr().Get(), mesh.GetOrientationAttr().Get()
    expected = UsdGeom.Tokens.none, UsdGeom.Tokens.rightHanded
    for attribute, value, required in zip(
        ("subdivisionScheme", "orientation"), conventions, expected, strict=True
    ):
        if value != required:
            yield attribute, str(value), str(required)


def _collider_flaws(
    prim: Any, kind: str, has_collision_schema: bool, is_guide: bool
) -> Iterator[tuple[str, str, str]]:
    """Yields the schemas and attributes that keep a collider from colliding, from being convex, or from being
    hidden."""
    if not is_guide:
        yield "purpose", "default", "guide"
    if not has_collision_schema:
        yield "apiSchemas", "no PhysicsCollisionAPI", "PhysicsCollisionAPI"
        return
    if not UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Get():
        yield "physics:collisionEnabled", "false", "true"
    if kind == "mesh":
        if "PhysicsMeshCollisionAPI" not in schemas(prim):
            yield "apiSchemas", "no PhysicsMeshCollisionAPI", "PhysicsMeshCollisionAPI"
        approximation = UsdPhysics.MeshCollisionAPI(prim).GetApproximationAttr().Get() or "none"
        if approximation != UsdPhysics.Tokens.convexHull:
            yield "physics:approximation", str(approximation), str(UsdPhysics.Tokens.convexHull)


def _size(prim: Any, kind: str, scale: Array) -> tuple[float, ...]:
    """Returns the size [m] of a primitive with its scale (3,) applied; () for a mesh."""

    def number(name: str) -> float:
        return float(prim.GetAttribute(name).Get())

    if kind == "box":
        return tuple(float(number("size") * factor) for factor in scale)
    if kind == "sphere":
        return (number("radius") * float(scale[0]),)
    if kind in ("cylinder", "capsule"):
        return number("radius") * float(scale[0]), number("height") * float(scale[2])
    return ()


def _points(prim: Any, body_from_prim: Array) -> Array:
    """Returns the points (n, 3) [m] of a mesh in its body's frame; none for a prim that is not a mesh."""
    points = UsdGeom.Mesh(prim).GetPointsAttr().Get() if prim.IsA(UsdGeom.Mesh) else None
    local = np.array(points if points else np.zeros((0, 3)), dtype=float)
    return np.asarray(local @ body_from_prim[:3, :3].T + body_from_prim[:3, 3])


def _corners(prim: Any, points: Array) -> npt.NDArray[np.float32] | None:
    """Returns the corners (n, 3, 3) of a mesh's triangles; None if the faces are not triangles of its
    points."""
    if not len(points):
        return None
    mesh = UsdGeom.Mesh(prim)
    corner_counts, indices = (
        np.array(attribute.Get() or (), dtype=np.int64)
        for attribute in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr())
    )
    is_triangular = len(indices) == 3 * len(corner_counts) and bool((corner_counts == 3).all())
    if not is_triangular or (len(indices) and not 0 <= indices.min() <= indices.max() < len(points)):
        return None
    return points.astype(np.float32)[indices].reshape(-1, 3, 3)


def _texcoords(prim: Any, triangle_count: int) -> npt.NDArray[np.float32] | None:
    """Returns the texture coordinates (triangle_count, 3, 2); None unless each corner has them."""
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
    texcoords = primvar.ComputeFlattened() if primvar else None
    if texcoords is None or len(texcoords) != 3 * triangle_count:
        return None
    return np.array(texcoords, dtype=np.float32).reshape(-1, 3, 2)
