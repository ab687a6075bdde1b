"""Reads the bodies and joints of a USD, with lengths in metres and angles in radians."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Tf, Usd, UsdGeom, UsdPhysics

from linkwright.stages.formats.usd.joint_facts import JointFacts
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.poses import from_parts, rotation_from_quat
from linkwright.stages.robot.model.robot import Array, Inertial, frozen
from linkwright.stages.validate.usd.place_reader import ReadUsdPlace, places_of
from linkwright.stages.validate.usd.prim_reader import flaws, schemas
from linkwright.stages.validate.usd.shape_reader import ReadUsdShape, shapes_of

SELF_COLLISION = (
    ("PhysxArticulationAPI", "physxArticulation:enabledSelfCollisions"),
    ("NewtonArticulationRootAPI", "newton:selfCollisionEnabled"),
)
"""The schemas that say whether an articulation collides with itself, and their attributes."""

OWN = re.compile(
    "physics:(axis|lowerLimit|upperLimit|coneAngle[01]Limit|localPos[01]|localRot[01]|body[01]"
    "|excludeFromArticulation)|limit:.*|physxArticulation:.*|newton:selfCollisionEnabled|xformOp.*"
    "|proxyPrim|visibility|purpose"
)
"""Attributes and relationships of a joint that are not among its `facts`."""

STARTS = ("physics:velocity", "physics:angularVelocity", "physics:startsAsleep")

AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}


FreeRanges = Mapping[tuple[str, str], tuple[float, float]]
"""The ranges [m or rad] of what a general joint leaves free, by ("trans", "X")."""


class UsdError(Exception):
    """The file cannot be read as a robot."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdBody:
    """Where a body stands (4, 4), and its mass properties. `moves`: whether forces move it; `starts`: its
    speeds at the start [m/s, deg/s], and whether it sleeps, by attribute. `shapes`: what it looks like and
    collides with; `places`: frames and cameras, by name; `apart`: the bodies that it does not collide with;
    `schemas`: what is applied to it."""

    world_from_body: Array
    inertial: Inertial
    moves: bool
    starts: Mapping[str, float]
    shapes: tuple[ReadUsdShape, ...]
    places: Mapping[str, ReadUsdPlace]
    apart: frozenset[str]
    schemas: frozenset[str]


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdJoint:
    """A joint: its type in UsdPhysics, its bodies, "" for none, the path of the prim that its first frame is
    in, and its frame (4, 4) on both; the unit vector
    (3,) of its axis, and its letter; its range, infinite where open; of a general joint the ranges of what is
    free, by ("trans", "X"). `closes`: whether it is outside the articulation; `facts`: all else that its prim
    says, with targets by the names of their prims."""

    type: str
    first: str
    second: str
    place: str
    first_from_joint: Array
    second_from_joint: Array
    axis: Array
    letter: str
    ends: tuple[float, float]
    free: FreeRanges
    closes: bool
    facts: JointFacts


@dataclass(frozen=True, slots=True, eq=False)
class UsdRobot:
    """Bodies and joints by the names of their prims; `roots`: the prims that begin an articulation, with what
    each engine says of whether its bodies collide with each other, by attribute. `units`: metres and
    kilograms per unit; `up`: the axis that points upwards; `path`: of the default prim.
    `flaws`: what is wrong whatever robot it is."""

    bodies: Mapping[str, ReadUsdBody]
    joints: Mapping[str, ReadUsdJoint]
    roots: Mapping[str, Mapping[str, bool]]
    units: tuple[float, float]
    up: str
    path: str
    flaws: tuple[Finding, ...]


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
    up = str(UsdGeom.GetStageUpAxis(stage))
    return UsdRobot(bodies, joints, roots, units, up, str(top.GetPath()), tuple(flaws(stage, top)))


def _collides(root: Any) -> dict[str, bool]:
    """Whether the bodies of an articulation collide with each other, in PhysX and in Newton: in both they do
    unless it is said, by an attribute of a schema that is applied."""
    applied = schemas(root)
    found = {}
    for schema, name in SELF_COLLISION:
        found[name] = not (schema in applied and root.GetAttribute(name).Get() is False)
    return found


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
    filters = UsdPhysics.FilteredPairsAPI(prim).GetFilteredPairsRel()
    apart = filters.GetTargets() if prim.HasAPI(UsdPhysics.FilteredPairsAPI) else []
    return ReadUsdBody(
        np.array(world).T,
        Inertial(float(api.GetMassAttr().Get()), frozen(com), frozen(inertia)),
        bool(moves),
        {name: float(np.linalg.norm(prim.GetAttribute(name).Get())) for name in STARTS},
        tuple(shapes_of(prim)),
        dict(places_of(prim)),
        frozenset(str(path.name) for path in apart if path in bodies),
        schemas(prim),
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
    letter = str(axis.Get()) if axis else "X"
    return ReadUsdJoint(
        kind,
        first,
        second,
        " ".join(map(str, joint.GetBody0Rel().GetTargets())),
        one,
        other,
        np.array(AXES[letter]),
        letter,
        ends,
        {} if kind else dict(_free(prim)),
        bool(joint.GetExcludeFromArticulationAttr().Get()),
        _facts(prim),
    )


def _target(relation: Any, bodies: set[Any]) -> str:
    """The name of the body, by its path: the default prim, which holds them all, may have a link's name."""
    paths = relation.GetTargets()
    return str(paths[0].name) if paths and paths[0] in bodies else ""


def _free(prim: Any) -> Iterator[tuple[tuple[str, str], tuple[float, float]]]:
    """Of a general joint: what is free, and its range [m or rad]. What is locked has a lower limit above the
    upper one."""
    for kind, scale in (("trans", 1.0), ("rot", math.pi / 180)):
        for axis in AXES:
            ends = [prim.GetAttribute(f"limit:{kind}{axis}:physics:{end}") for end in ("low", "high")]
            low, high = (
                end.Get() * scale if end else side
                for end, side in zip(ends, (-math.inf, math.inf), strict=True)
            )
            if low <= high:
                yield (kind, axis), (low, high)


def _facts(prim: Any) -> JointFacts:
    """What the prim of a joint says that nothing else reads."""
    said = {
        one.GetName(): one.Get() for one in prim.GetAuthoredAttributes() if not OWN.fullmatch(one.GetName())
    }
    targets = {
        one.GetName(): " ".join(str(path.name) for path in one.GetTargets())
        for one in prim.GetAuthoredRelationships()
        if not OWN.fullmatch(one.GetName())
    }
    numbers = {name: float(value) for name, value in said.items() if isinstance(value, int | float)}
    words = {name: str(value) for name, value in said.items() if name not in numbers}
    return JointFacts(tuple(sorted(schemas(prim))), numbers, words, targets)


def _rotation(quat: Any) -> Array:
    return rotation_from_quat(np.array([quat.GetReal(), *quat.GetImaginary()]))
