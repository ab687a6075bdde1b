"""Reads what the bodies of a USD look like and collide with, in metres."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Usd, UsdGeom, UsdPhysics

from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.usd.look_reader import ReadUsdLook, look_of
from linkwright.stages.validate.usd.prim_reader import schemas

KINDS = {"Cube": "box", "Sphere": "sphere", "Cylinder": "cylinder", "Capsule": "capsule", "Mesh": "mesh"}
"""What shapes are called elsewhere, by the types of their prims."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdShape:
    """A shape of a body. `collides`: whether it is one to collide with: it has UsdPhysics's schema for that,
    or is a guide, which is not drawn. `lacks`: the schemas and attributes that keep it from colliding, or
    from being convex, or that make another surface of it, as (attribute, found, expected). `size` [m] as in
    `model.Primitive`, () of a mesh; `body_from_shape` (4, 4), without scale. Of a mesh, in the body's frame:
    `bounds` (6,) [m] of its points, the least x, y and z and the largest, () without any; the `corners`
    (n, 3, 3) [m] of its triangles, None where its faces are no triangles of its points; and their `texcoords`
    (n, 3, 2), None where there are none for each corner. `look`: its materials."""

    name: str
    kind: str
    collides: bool
    lacks: tuple[tuple[str, str, str], ...]
    size: tuple[float, ...]
    body_from_shape: Array
    bounds: tuple[float, ...]
    corners: npt.NDArray[np.float32] | None
    texcoords: npt.NDArray[np.float32] | None
    look: ReadUsdLook


def shapes_of(body: Any) -> Iterator[ReadUsdShape]:
    """Those of a prim and of what is below it, in their order, within instances too."""
    cache = UsdGeom.XformCache()
    body_from_world = inverse(np.array(cache.GetLocalToWorldTransform(body)).T)
    for prim in Usd.PrimRange(body, Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdGeom.Gprim):
            yield _shape(prim, body_from_world @ np.array(cache.GetLocalToWorldTransform(prim)).T)


def _shape(prim: Any, body_from_prim: Array) -> ReadUsdShape:
    kind = KINDS.get(prim.GetTypeName(), prim.GetTypeName())
    has = prim.HasAPI(UsdPhysics.CollisionAPI)
    guide = UsdGeom.Imageable(prim).ComputePurpose() == UsdGeom.Tokens.guide
    scale = np.linalg.norm(body_from_prim[:3, :3], axis=0)
    place = body_from_prim.copy()
    place[:3, :3] /= np.where(scale > 0, scale, 1.0)
    collides = has or guide
    points = _points(prim, body_from_prim)
    corners = _corners(prim, points)
    return ReadUsdShape(
        prim.GetName(),
        kind,
        collides,
        (*_unlike(prim, kind), *(_lacks(prim, kind, has, guide) if collides else ())),
        _size(prim, kind, scale),
        place,
        (*map(float, points.min(axis=0)), *map(float, points.max(axis=0))) if len(points) else (),
        corners,
        None if corners is None else _texcoords(prim, len(corners)),
        look_of(prim),
    )


def _unlike(prim: Any, kind: str) -> Iterator[tuple[str, str, str]]:
    """What would make another surface of the triangles of a mesh."""
    if kind != "mesh":
        return
    mesh = UsdGeom.Mesh(prim)
    found = mesh.GetSubdivisionSchemeAttr().Get(), mesh.GetOrientationAttr().Get()
    wanted = UsdGeom.Tokens.none, UsdGeom.Tokens.rightHanded
    for attribute, one, other in zip(("subdivisionScheme", "orientation"), found, wanted, strict=True):
        if one != other:
            yield attribute, str(one), str(other)


def _lacks(prim: Any, kind: str, has: bool, guide: bool) -> Iterator[tuple[str, str, str]]:
    if not guide:
        yield "purpose", "default", "guide"
    if not has:
        yield "apiSchemas", "no PhysicsCollisionAPI", "PhysicsCollisionAPI"
        return
    if not UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Get():
        yield "physics:collisionEnabled", "false", "true"
    if kind == "mesh":
        if "PhysicsMeshCollisionAPI" not in schemas(prim):
            yield "apiSchemas", "no PhysicsMeshCollisionAPI", "PhysicsMeshCollisionAPI"
        found = UsdPhysics.MeshCollisionAPI(prim).GetApproximationAttr().Get() or "none"
        if found != UsdPhysics.Tokens.convexHull:
            yield "physics:approximation", str(found), str(UsdPhysics.Tokens.convexHull)


def _size(prim: Any, kind: str, scale: Array) -> tuple[float, ...]:
    def number(name: str) -> float:
        return float(prim.GetAttribute(name).Get())

    if kind == "box":
        return tuple(float(number("size") * one) for one in scale)
    if kind == "sphere":
        return (number("radius") * float(scale[0]),)
    if kind in ("cylinder", "capsule"):
        return number("radius") * float(scale[0]), number("height") * float(scale[2])
    return ()


def _points(prim: Any, body_from_prim: Array) -> Array:
    """The points (N, 3) of a mesh in its body's frame [m]; none of what is no mesh."""
    points = UsdGeom.Mesh(prim).GetPointsAttr().Get() if prim.IsA(UsdGeom.Mesh) else None
    found = np.array(points if points else np.zeros((0, 3)), dtype=float)
    return np.asarray(found @ body_from_prim[:3, :3].T + body_from_prim[:3, 3])


def _corners(prim: Any, points: Array) -> npt.NDArray[np.float32] | None:
    """The triangles (N, 3, 3) of a mesh; None where its faces are others, or have no points."""
    if not len(points):
        return None
    mesh = UsdGeom.Mesh(prim)
    sides, index = (
        np.array(one.Get() or (), dtype=np.int64)
        for one in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr())
    )
    whole = len(index) == 3 * len(sides) and bool((sides == 3).all())
    if not whole or (len(index) and not 0 <= index.min() <= index.max() < len(points)):
        return None
    return points.astype(np.float32)[index].reshape(-1, 3, 3)


def _texcoords(prim: Any, triangles: int) -> npt.NDArray[np.float32] | None:
    places = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
    found = places.ComputeFlattened() if places else None
    if found is None or len(found) != 3 * triangles:
        return None
    return np.array(found, dtype=np.float32).reshape(-1, 3, 2)
