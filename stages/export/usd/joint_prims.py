"""Joints of a USD as prims: frames, limits, resistance, state, drive and relations, in the words of
UsdPhysics, of PhysX and of Newton.

UsdPhysics has angles in degrees, and so have both engines' own attributes: what is for each radian is π/180
of it for each degree.
"""

import math

from stages.export.usd.drives import Drive
from stages.export.usd.joints import UsdJoint
from stages.export.usd.layer import Prim
from stages.formats.numbers import LENGTH, TURN
from stages.robot.model import Array, Limits, Relation

DEGREES = 180.0 / math.pi


def write_joint(prim: Prim, joint: UsdJoint) -> None:
    """What a joint is, without its bodies and frames."""
    if joint.closes:
        prim.set("physics:excludeFromArticulation", "bool", True, uniform=True)
    if joint.dof is not None:
        prim.token("physics:axis", joint.axis)
        if not joint.closes:  # PhysX would warn: only joints of an articulation resist motion
            _passive(prim, joint)
    if joint.type == "":
        _locks(prim, joint)
    elif joint.type == "Spherical" and joint.limits.upper is not None:
        for key in ("coneAngle0Limit", "coneAngle1Limit"):
            prim.number(f"physics:{key}", joint.limits.upper * DEGREES, least=TURN)
    elif joint.type in ("Revolute", "Prismatic"):
        _limits(prim, joint)


def write_state(prim: Prim, joint: UsdJoint, value: float, drive: Drive | None) -> None:
    """Where a turn or slide is [rad or m], and what drives it."""
    scale, least = _units(joint)
    prim.apply(f"PhysicsJointStateAPI:{joint.drive}")
    prim.number(f"state:{joint.drive}:physics:position", value * scale, least=least)
    if drive is None:
        return
    prim.apply(f"PhysicsDriveAPI:{joint.drive}")
    before = f"drive:{joint.drive}:physics:"
    prim.token(f"{before}type", "force")
    prim.number(f"{before}stiffness", drive.stiffness / scale)
    prim.number(f"{before}damping", drive.damping / scale)
    if drive.force is not None:
        prim.number(f"{before}maxForce", drive.force)
    prim.number(f"{before}targetPosition", drive.target * scale, least=least)


def write_mimic(prim: Prim, joint: UsdJoint, relation: Relation, other: Prim, driver: UsdJoint) -> None:
    """A relation on its follower: in Newton's words between two of one kind, in PhysX's of any."""
    scale, least = _units(joint)
    multiplier = relation.multiplier * scale / _units(driver)[0]
    if joint.type == driver.type:
        prim.apply("NewtonMimicAPI")
        prim.point_to("newton:mimicJoint", other)
        prim.number("newton:mimicCoef0", relation.offset * scale, least=least)
        prim.number("newton:mimicCoef1", multiplier)
    # PhysX: position + gearing · reference + offset = 0.
    own = f"rot{joint.axis}"
    prim.apply(f"PhysxMimicJointAPI:{own}")
    before = f"physxMimicJoint:{own}:"
    prim.point_to(f"{before}referenceJoint", other)
    prim.token(f"{before}referenceJointAxis", f"rot{driver.axis}")
    prim.number(f"{before}gearing", -multiplier)
    prim.number(f"{before}offset", -relation.offset * scale, least=least)


def write_frames(prim: Prim, first: Array, second: Array) -> None:
    """Where a joint's frame is (4, 4) on both of its bodies."""
    for number, pose in ((0, first), (1, second)):
        prim.floats(f"physics:localPos{number}", "point3f", pose[:3, 3], LENGTH)
        prim.turned(f"physics:localRot{number}", pose[:3, :3])


def _units(joint: UsdJoint) -> tuple[float, float]:
    """What a value is in USD's unit, degrees or metres, and what it is measured by there."""
    return (DEGREES, TURN * DEGREES) if joint.turns else (1.0, LENGTH)


def _limits(prim: Prim, joint: UsdJoint) -> None:
    scale, least = _units(joint)
    for key, end in (("lowerLimit", joint.limits.lower), ("upperLimit", joint.limits.upper)):
        if end is not None:
            prim.number(f"physics:{key}", end * scale, least=least)


def _locks(prim: Prim, joint: UsdJoint) -> None:
    """What a general joint leaves free, within limits; the rest is locked, by a lower limit above the upper
    one."""
    freed = {f"{one.kind}{one.axis}": one for one in joint.free}
    for kind in ("trans", "rot"):
        for axis in "XYZ":
            name = f"{kind}{axis}"
            limits = freed[name].limits if name in freed else None
            if limits == Limits():
                continue
            prim.apply(f"PhysicsLimitAPI:{name}")
            scale, least = (DEGREES, TURN * DEGREES) if kind == "rot" else (1.0, LENGTH)
            ends = (1.0, -1.0) if limits is None else (limits.lower, limits.upper)
            for key, end in zip(("low", "high"), ends, strict=True):
                if end is not None:
                    own = end if limits is None else end * scale
                    prim.number(f"limit:{name}:physics:{key}", own, least=least)


def _passive(prim: Prim, joint: UsdJoint) -> None:
    """Armature, damping, friction and largest speed, in Newton's attributes and both PhysX's."""
    dynamics = joint.dynamics
    scale = 1.0 if joint.type == "Prismatic" else DEGREES
    damping, velocity = dynamics.damping, dynamics.velocity
    found = {
        "armature": dynamics.armature,
        "damping": None if damping is None else damping / scale,
        "friction": dynamics.friction,
        "velocityLimit": None if velocity is None else velocity * scale,
    }
    given = {name: value for name, value in found.items() if value is not None}
    if not given:
        return
    prim.apply("NewtonJointAPI")
    for name, value in given.items():
        prim.number(f"newton:{name}", value)
    known = {"armature": "armature", "velocityLimit": "maxJointVelocity"}
    if given.keys() & known.keys():
        prim.apply("PhysxJointAPI")
        for name, own in known.items():
            if name in given:
                prim.number(f"physxJoint:{own}", given[name])
    if joint.type == "Spherical":
        return
    known |= {"damping": "viscousFrictionCoefficient"}
    prim.apply(f"PhysxJointAxisAPI:{joint.drive}")
    before = f"physxJointAxis:{joint.drive}:"
    for name, own in known.items():
        if name in given:
            prim.number(f"{before}{own}", given[name])
    if "friction" in given:
        for own in ("staticFrictionEffort", "dynamicFrictionEffort"):
            prim.number(f"{before}{own}", given["friction"])
