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
from linkwright.stages.validate.usd.actuators import ReadUsdActuator, read_actuators
from linkwright.stages.validate.usd.place_reader import ReadUsdPlace, places_of
from linkwright.stages.validate.usd.prim_reader import filtered_paths, flaws, schemas
from linkwright.stages.validate.usd.shape_reader import ReadUsdShape, shapes_of

SELF_COLLISION = (
    ("PhysxArticulationAPI", "physxArticulation:enabledSelfCollisions"),
    ("NewtonArticulationRootAPI", "newton:selfCollisionEnabled"),
)
"""The schemas that decide whether an articulation collides with itself, and their attributes."""

READ_PROPERTIES = re.compile(
    "physics:(axis|lowerLimit|upperLimit|coneAngle[01]Limit|localPos[01]|localRot[01]|body[01]"
    "|excludeFromArticulation)|limit:.*|physxArticulation:.*|newton:selfCollisionEnabled|xformOp.*"
    "|proxyPrim|visibility|purpose"
)
"""Attributes and relationships of a joint that are not among its `facts`."""

START_ATTRIBUTES = ("physics:velocity", "physics:angularVelocity", "physics:startsAsleep")
"""Attributes of a body's state at the start of a simulation."""

AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
"""Name of an axis → its unit vector."""

FreeRanges = Mapping[tuple[str, str], tuple[float, float]]
"""The ranges [m or rad] of a general joint's free motions, by kind and axis, such as ("trans", "X")."""


class UsdError(Exception):
    """The file cannot be read as a robot."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdBody:
    """A body of a USD."""

    world_from_body: Array
    """The pose (4, 4)."""

    inertial: Inertial
    moves: bool
    """Whether forces move the body."""

    starts: Mapping[str, float]
    """The speeds at the start [m/s, deg/s], and 1 if the body sleeps, by attribute."""

    shapes: tuple[ReadUsdShape, ...]
    """The visual shapes and colliders."""

    places: Mapping[str, ReadUsdPlace]
    """The frames and cameras, by name."""

    filtered: frozenset[str]
    """The names of the bodies with which the body does not collide."""

    schemas: frozenset[str]
    """The applied schemas."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdJoint:
    """A joint of a USD."""

    type: str
    """The type in UsdPhysics."""

    first: str
    """The name of the first body; "" without a body."""

    second: str
    """The name of the second body; "" without a body."""

    first_path: str
    """The path of the prim that has the first frame, which need not be a body."""

    first_from_joint: Array
    """The frame (4, 4) on the first body."""

    second_from_joint: Array
    """The frame (4, 4) on the second body."""

    axis: Array
    """The unit vector (3,) of the axis."""

    axis_name: str
    """The name of the axis in `AXES`."""

    ends: tuple[float, float]
    """The range [m or rad], with infinite ends if there is no limit."""

    free_ranges: FreeRanges
    """The free motions of a general joint, with their ranges."""

    closes: bool
    """Whether the joint is outside the articulation."""

    facts: JointFacts
    """All other attributes of the prim; targets are the names of prims."""


@dataclass(frozen=True, slots=True, eq=False)
class UsdRobot:
    """The robot of a USD. Bodies, joints and actuators are by the names of their prims."""

    bodies: Mapping[str, ReadUsdBody]
    joints: Mapping[str, ReadUsdJoint]
    roots: Mapping[str, Mapping[str, bool]]
    """The prims that begin an articulation, with each engine's attribute for collisions between its
    bodies."""

    actuators: Mapping[str, ReadUsdActuator]
    units: tuple[float, float]
    """Metres and kilograms per unit."""

    up: str
    """The axis that points upwards."""

    path: str
    """The path of the default prim."""

    flaws: tuple[Finding, ...]
    """Errors that do not depend on the robot."""


def read_usd(path: Path) -> UsdRobot:
    """Reads the robot of the file's default prim. Raises UsdError if there is no such robot."""
    try:
        stage = Usd.Stage.Open(str(path))
    except Tf.ErrorException as error:
        raise UsdError(" ".join(str(error).split())) from None
    top = stage.GetDefaultPrim()
    if not top:
        msg = "it has no default prim"
        raise UsdError(msg)
    prims = list(Usd.PrimRange(top))
    moving = [prim for prim in prims if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    paths = {prim.GetPath() for prim in moving}
    bodies = {prim.GetName(): _body(prim, paths) for prim in moving}
    joints = {
        prim.GetName(): _joint(UsdPhysics.Joint(prim), paths) for prim in prims if prim.IsA(UsdPhysics.Joint)
    }
    roots = {
        prim.GetName(): _self_collisions(prim)
        for prim in prims
        if prim.HasAPI(UsdPhysics.ArticulationRootAPI)
    }
    units = UsdGeom.GetStageMetersPerUnit(stage), UsdPhysics.GetStageKilogramsPerUnit(stage)
    up = str(UsdGeom.GetStageUpAxis(stage))
    return UsdRobot(
        bodies, joints, roots, read_actuators(prims), units, up, str(top.GetPath()), tuple(flaws(stage, top))
    )


def _self_collisions(root: Any) -> dict[str, bool]:
    """Returns whether the bodies of an articulation collide with each other in PhysX and in Newton, by the
    engine's attribute. In both they do, unless the attribute forbids it and its schema is applied."""
    applied = schemas(root)
    by_attribute = {}
    for schema, name in SELF_COLLISION:
        by_attribute[name] = not (schema in applied and root.GetAttribute(name).Get() is False)
    return by_attribute


def _body(prim: Any, bodies: set[Any]) -> ReadUsdBody:
    api = UsdPhysics.MassAPI(prim)
    axes = _rotation(api.GetPrincipalAxesAttr().Get())
    moments = np.array(api.GetDiagonalInertiaAttr().Get(), dtype=float)
    com = np.array(api.GetCenterOfMassAttr().Get(), dtype=float)
    inertia = axes @ np.diag(moments) @ axes.T
    row_matrix = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    rigid = UsdPhysics.RigidBodyAPI(prim)
    moves = rigid.GetRigidBodyEnabledAttr().Get() and not rigid.GetKinematicEnabledAttr().Get()
    return ReadUsdBody(
        # USD's matrices act on rows.
        np.array(row_matrix).T,
        Inertial(float(api.GetMassAttr().Get()), frozen(com), frozen(inertia)),
        bool(moves),
        {name: float(np.linalg.norm(prim.GetAttribute(name).Get())) for name in START_ATTRIBUTES},
        tuple(shapes_of(prim)),
        dict(places_of(prim)),
        frozenset(str(path.name) for path in filtered_paths(prim) if path in bodies),
        schemas(prim),
    )


def _joint(joint: Any, bodies: set[Any]) -> ReadUsdJoint:
    prim = joint.GetPrim()
    kind = prim.GetTypeName().removeprefix("Physics").removesuffix("Joint")
    first, second = (_body_name(relation, bodies) for relation in (joint.GetBody0Rel(), joint.GetBody1Rel()))
    axis = prim.GetAttribute("physics:axis")
    ends = (-math.inf, math.inf)
    if kind in ("Revolute", "Prismatic"):
        scale = math.pi / 180 if kind == "Revolute" else 1.0
        low, high = (prim.GetAttribute(f"physics:{end}Limit").Get() * scale for end in ("lower", "upper"))
        ends = low, high
    elif kind == "Spherical":
        # A negative angle means no limit.
        cone = prim.GetAttribute("physics:coneAngle0Limit").Get()
        ends = (-math.inf, math.inf if cone < 0 else cone * math.pi / 180)
    frame_attributes = (
        (joint.GetLocalPos0Attr(), joint.GetLocalRot0Attr()),
        (joint.GetLocalPos1Attr(), joint.GetLocalRot1Attr()),
    )
    first_from_joint, second_from_joint = (
        from_parts(_rotation(orientation.Get()), np.array(position.Get(), dtype=float))
        for position, orientation in frame_attributes
    )
    axis_name = str(axis.Get()) if axis else "X"
    return ReadUsdJoint(
        kind,
        first,
        second,
        " ".join(map(str, joint.GetBody0Rel().GetTargets())),
        first_from_joint,
        second_from_joint,
        np.array(AXES[axis_name]),
        axis_name,
        ends,
        {} if kind else dict(_free_ranges(prim)),
        bool(joint.GetExcludeFromArticulationAttr().Get()),
        _facts(prim),
    )


def _body_name(relation: Any, bodies: set[Any]) -> str:
    """Returns the name of the body that is the first target; "" if that is not a body. It is found by its
    path, since the default prim, which holds all bodies, may have a link's name."""
    paths = relation.GetTargets()
    return str(paths[0].name) if paths and paths[0] in bodies else ""


def _free_ranges(prim: Any) -> Iterator[tuple[tuple[str, str], tuple[float, float]]]:
    """Yields the free motions of a general joint, with their ranges [m or rad]. A locked motion has a lower
    limit above the upper one."""
    for kind, scale in (("trans", 1.0), ("rot", math.pi / 180)):
        for axis in AXES:
            ends = [prim.GetAttribute(f"limit:{kind}{axis}:physics:{end}") for end in ("low", "high")]
            low, high = (
                end.Get() * scale if end else open_end
                for end, open_end in zip(ends, (-math.inf, math.inf), strict=True)
            )
            if low <= high:
                yield (kind, axis), (low, high)


def _facts(prim: Any) -> JointFacts:
    """Returns the attributes and targets of a joint's prim that nothing else reads."""
    values = {
        attribute.GetName(): attribute.Get()
        for attribute in prim.GetAuthoredAttributes()
        if not READ_PROPERTIES.fullmatch(attribute.GetName())
    }
    targets = {
        relation.GetName(): " ".join(str(path.name) for path in relation.GetTargets())
        for relation in prim.GetAuthoredRelationships()
        if not READ_PROPERTIES.fullmatch(relation.GetName())
    }
    numbers = {name: float(value) for name, value in values.items() if isinstance(value, int | float)}
    tokens = {name: str(value) for name, value in values.items() if name not in numbers}
    return JointFacts(tuple(sorted(schemas(prim))), numbers, tokens, targets)


def _rotation(quat: Any) -> Array:
    """Returns the rotation (3, 3) of a quaternion of USD."""
    return rotation_from_quat(np.array([quat.GetReal(), *quat.GetImaginary()]))
