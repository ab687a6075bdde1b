"""Reads the bodies and joints of a USD, with lengths in metres and angles in radians."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Tf, Usd, UsdGeom, UsdPhysics

from stages.robot.model import Array, Inertial, frozen
from stages.robot.poses import from_parts, rotation_from_quat
from stages.validate.usd.shape_reader import ReadUsdShape, shapes_of

AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}


class UsdError(Exception):
    """The file cannot be read as a robot."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdBody:
    """Where a body stands (4, 4), and its mass properties. `moves`: whether forces move it. `shapes`: what it
    looks like and collides with; `apart`: the bodies that it does not collide with."""

    world_from_body: Array
    inertial: Inertial
    moves: bool
    shapes: tuple[ReadUsdShape, ...]
    apart: frozenset[str]


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdJoint:
    """A joint: its type in UsdPhysics, its bodies, "" for none, and its frame (4, 4) on both; the unit vector
    (3,) of its axis; its range, infinite where open; of a general joint what is free, as ("trans", "X").
    `closes`: whether it is outside the articulation."""

    type: str
    first: str
    second: str
    first_from_joint: Array
    second_from_joint: Array
    axis: Array
    ends: tuple[float, float]
    free: tuple[tuple[str, str], ...]
    closes: bool


@dataclass(frozen=True, slots=True, eq=False)
class UsdRobot:
    """Bodies and joints by the names of their prims; `roots`: the prims that begin an articulation, and
    whether its bodies collide with each other. `units`: metres and kilograms per unit; `up`: the axis that
    points upwards."""

    bodies: Mapping[str, ReadUsdBody]
    joints: Mapping[str, ReadUsdJoint]
    roots: Mapping[str, bool]
    units: tuple[float, float]
    up: str


def read_usd(path: Path) -> UsdRobot:
    """The robot of the file's default prim. UsdError where there is none."""
    try:
        stage = Usd.Stage.Open(str(path))
    except Tf.ErrorException as error:
        raise UsdError(" ".join(str(error).split())) from None
    top = stage.GetDefaultPrim()
    if not top:
        msg = "it has no default prim"
        raise UsdError(msg)
    prims = list(Usd.PrimRange(top))
    moving = [one for one in prims if one.HasAPI(UsdPhysics.RigidBodyAPI)]
    paths = {one.GetPath() for one in moving}
    bodies = {one.GetName(): _body(one, paths) for one in moving}
    joints = {
        one.GetName(): _joint(UsdPhysics.Joint(one), paths) for one in prims if one.IsA(UsdPhysics.Joint)
    }
    roots = {one.GetName(): _collides(one) for one in prims if one.HasAPI(UsdPhysics.ArticulationRootAPI)}
    units = UsdGeom.GetStageMetersPerUnit(stage), UsdPhysics.GetStageKilogramsPerUnit(stage)
    return UsdRobot(bodies, joints, roots, units, str(UsdGeom.GetStageUpAxis(stage)))


def _collides(root: Any) -> bool:
    """Whether the bodies of an articulation collide with each other: in PhysX they do unless it is said."""
    return root.GetAttribute("physxArticulation:enabledSelfCollisions").Get() is not False


def _body(prim: Any, bodies: set[Any]) -> ReadUsdBody:
    api = UsdPhysics.MassAPI(prim)
    axes = _rotation(api.GetPrincipalAxesAttr().Get())
    moments = np.array(api.GetDiagonalInertiaAttr().Get(), dtype=float)
    com = np.array(api.GetCenterOfMassAttr().Get(), dtype=float)
    inertia = axes @ np.diag(moments) @ axes.T
    world = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    # USD's matrices act on rows.
    rigid = UsdPhysics.RigidBodyAPI(prim)
    moves = rigid.GetRigidBodyEnabledAttr().Get() and not rigid.GetKinematicEnabledAttr().Get()
    apart = UsdPhysics.FilteredPairsAPI(prim).GetFilteredPairsRel().GetTargets()
    return ReadUsdBody(
        np.array(world).T,
        Inertial(float(api.GetMassAttr().Get()), frozen(com), frozen(inertia)),
        bool(moves),
        tuple(shapes_of(prim)),
        frozenset(str(path.name) for path in apart if path in bodies),
    )


def _joint(joint: Any, bodies: set[Any]) -> ReadUsdJoint:
    prim = joint.GetPrim()
    kind = prim.GetTypeName().removeprefix("Physics").removesuffix("Joint")
    first, second = (_target(one, bodies) for one in (joint.GetBody0Rel(), joint.GetBody1Rel()))
    axis = prim.GetAttribute("physics:axis")
    ends = (-math.inf, math.inf)
    if kind in ("Revolute", "Prismatic"):
        scale = math.pi / 180 if kind == "Revolute" else 1.0
        low, high = (prim.GetAttribute(f"physics:{end}Limit").Get() * scale for end in ("lower", "upper"))
        ends = low, high
    elif kind == "Spherical":
        cone = prim.GetAttribute("physics:coneAngle0Limit").Get()
        ends = (-math.inf, math.inf if cone < 0 else cone * math.pi / 180)
    places = (
        (joint.GetLocalPos0Attr(), joint.GetLocalRot0Attr()),
        (joint.GetLocalPos1Attr(), joint.GetLocalRot1Attr()),
    )
    one, other = (from_parts(_rotation(turn.Get()), np.array(at.Get(), dtype=float)) for at, turn in places)
    free = tuple((one, axis) for one in ("trans", "rot") for axis in AXES if not _locked(prim, one + axis))
    return ReadUsdJoint(
        kind,
        first,
        second,
        one,
        other,
        np.array(AXES[axis.Get() if axis else "X"]),
        ends,
        free if not kind else (),
        bool(joint.GetExcludeFromArticulationAttr().Get()),
    )


def _target(relation: Any, bodies: set[Any]) -> str:
    """The name of the body, by its path: the default prim, which holds them all, may have a link's name."""
    paths = relation.GetTargets()
    return str(paths[0].name) if paths and paths[0] in bodies else ""


def _locked(prim: Any, name: str) -> bool:
    low, high = (prim.GetAttribute(f"limit:{name}:physics:{end}") for end in ("low", "high"))
    return bool(low and high and low.Get() > high.Get())


def _rotation(quat: Any) -> Array:
    return rotation_from_quat(np.array([quat.GetReal(), *quat.GetImaginary()]))
