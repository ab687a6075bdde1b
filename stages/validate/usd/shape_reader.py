"""Reads what the bodies of a USD look like and collide with, in metres."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from stages.robot.model import Array
from stages.robot.poses import inverse

KINDS = {"Cube": "box", "Sphere": "sphere", "Cylinder": "cylinder", "Capsule": "capsule", "Mesh": "mesh"}
"""What shapes are called elsewhere, by the types of their prims."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdShape:
    """A shape of a body. `collides`: whether it is one to collide with: it has UsdPhysics's schema for that,
    or is a guide, which is not drawn; of these `lacks`: the schemas and attributes that keep it from
    colliding, or from being convex, as (attribute, found, expected). `size` [m] as in `model.Primitive`, ()
    of a mesh; `body_from_shape` (4, 4), without scale; `bounds` (6,) [m] of a mesh's points, in the body's
    frame: the least x, y and z and the largest."""

    name: str
    kind: str
    collides: bool
    lacks: tuple[tuple[str, str, str], ...]
    size: tuple[float, ...]
    body_from_shape: Array
    bounds: tuple[float, ...]


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
    lacks = tuple(_lacks(prim, kind, has)) if collides else ()
    return ReadUsdShape(
        prim.GetName(), kind, collides, lacks, _size(prim, kind, scale), place, _bounds(prim, body_from_prim)
    )


def _lacks(prim: Any, kind: str, has: bool) -> Iterator[tuple[str, str, str]]:
    if not has:
        yield "apiSchemas", "no PhysicsCollisionAPI", "PhysicsCollisionAPI"
        return
    if not UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Get():
        yield "physics:collisionEnabled", "false", "true"
    if kind == "mesh":
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


def _bounds(prim: Any, body_from_prim: Array) -> tuple[float, ...]:
    if not prim.IsA(UsdGeom.Mesh):
        return ()
    points = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get() or np.zeros((0, 3)), dtype=float)
    if not len(points):
        return ()
    moved = points @ body_from_prim[:3, :3].T + body_from_prim[:3, 3]
    return (*map(float, moved.min(axis=0)), *map(float, moved.max(axis=0)))
