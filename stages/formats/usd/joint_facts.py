"""Describes the properties of a USD's joints other than their bodies, frames and limits: resistance, state,
drive and relations, in the words of UsdPhysics, of PhysX, of Newton and of MuJoCo.

UsdPhysics has angles in degrees, and so have the attributes of PhysX and of Newton: a value per radian is
π/180 of it per degree. MuJoCo's own are in radians.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from linkwright.stages.formats.numbers import LENGTH, TURN, number
from linkwright.stages.formats.usd.drives import UNLIMITED, Drive
from linkwright.stages.robot.model.robot import Dof, Relation

DEGREES = 180.0 / math.pi
"""A radian in degrees."""

MUJOCO = "mjc:"
"""Namespace of MuJoCo's attributes, whose numbers are uniform and in double precision."""


@dataclass(frozen=True, slots=True)
class JointFacts:
    """The properties of a joint in a USD."""

    schemas: tuple[str, ...] = ()
    """The applied schemas."""

    numbers: Mapping[str, float] = field(default_factory=dict)
    """The attributes that are numbers, by name."""

    tokens: Mapping[str, str] = field(default_factory=dict)
    """The attributes that are tokens, by name."""

    targets: Mapping[str, str] = field(default_factory=dict)
    """The relationships, by name, to the joint of another dof."""

    def __or__(self, other: "JointFacts") -> "JointFacts":
        """Returns the properties of both, those of `other` in the place of equal names."""
        return JointFacts(
            (*self.schemas, *other.schemas),
            {**self.numbers, **other.numbers},
            {**self.tokens, **other.tokens},
            {**self.targets, **other.targets},
        )


def units(dof: Dof) -> tuple[float, float]:
    """Returns the size of a turn's or slide's unit in USD's unit, degrees or metres, and the scale of
    rounding there."""
    return (DEGREES, TURN * DEGREES) if dof.kind == "turn" else (1.0, LENGTH)


def drive_name(dof: Dof) -> str:
    """Returns UsdPhysics' name of a joint's only degree of freedom."""
    return "angular" if dof.kind == "turn" else "linear"


def resistance(dof: Dof) -> JointFacts:
    """Returns armature, damping, friction and largest speed, in the attributes of Newton, of both PhysX
    schemas, and of MuJoCo; MuJoCo's attributes include the largest force."""
    return _newton_and_physx_resistance(dof) | _mujoco_resistance(dof)


def _mujoco_resistance(dof: Dof) -> JointFacts:
    dynamics = dof.dynamics
    values = {"armature": dynamics.armature, "damping": dynamics.damping, "frictionloss": dynamics.friction}
    if dof.kind != "ball" and dynamics.effort is not None:
        values |= {"actuatorfrcrange:min": -dynamics.effort, "actuatorfrcrange:max": dynamics.effort}
    numbers = {f"{MUJOCO}{name}": value for name, value in values.items() if value is not None}
    return JointFacts(("MjcJointAPI",), numbers)


def _newton_and_physx_resistance(dof: Dof) -> JointFacts:
    dynamics = dof.dynamics
    scale = 1.0 if dof.kind == "slide" else DEGREES
    damping, velocity = dynamics.damping, dynamics.velocity
    quantities = {
        "armature": dynamics.armature,
        "damping": None if damping is None else damping / scale,
        "friction": dynamics.friction,
        "velocityLimit": None if velocity is None else velocity * scale,
    }
    values = {name: value for name, value in quantities.items() if value is not None}
    if not values:
        return JointFacts()
    schemas, numbers = ["NewtonJointAPI"], {f"newton:{name}": value for name, value in values.items()}
    physx_names = {"armature": "armature", "velocityLimit": "maxJointVelocity"}
    if values.keys() & physx_names.keys():
        schemas.append("PhysxJointAPI")
        numbers |= _renamed(values, physx_names, "physxJoint:")
    if dof.kind == "ball":
        return JointFacts(tuple(schemas), numbers)
    physx_names |= {"damping": "viscousFrictionCoefficient"}
    schemas.append(f"PhysxJointAxisAPI:{drive_name(dof)}")
    prefix = f"physxJointAxis:{drive_name(dof)}:"
    numbers |= _renamed(values, physx_names, prefix)
    if "friction" in values:
        for attribute in ("staticFrictionEffort", "dynamicFrictionEffort"):
            numbers[f"{prefix}{attribute}"] = values["friction"]
    return JointFacts(tuple(schemas), numbers)


def _renamed(values: Mapping[str, float], attributes: Mapping[str, str], prefix: str) -> dict[str, float]:
    return {f"{prefix}{attribute}": values[name] for name, attribute in attributes.items() if name in values}


def joint_state(dof: Dof, value: float) -> JointFacts:
    """Returns the state of a turn or a slide at a value [rad or m]."""
    scale, least = units(dof)
    position = {f"state:{drive_name(dof)}:physics:position": _rounded(value * scale, least)}
    return JointFacts((f"PhysicsJointStateAPI:{drive_name(dof)}",), position)


def joint_drive(dof: Dof, drive: Drive) -> JointFacts:
    """Returns the drive of a turn or a slide."""
    scale, least = units(dof)
    prefix = f"drive:{drive_name(dof)}:physics:"
    numbers = {f"{prefix}stiffness": drive.stiffness / scale, f"{prefix}damping": drive.damping / scale}
    numbers[f"{prefix}maxForce"] = UNLIMITED if drive.force is None else drive.force
    numbers[f"{prefix}targetPosition"] = _rounded(drive.target * scale, least)
    return JointFacts((f"PhysicsDriveAPI:{drive_name(dof)}",), numbers, {f"{prefix}type": "force"})


def joint_mimic(relation: Relation, follower: Dof, driver: Dof, axes: tuple[str, str]) -> JointFacts:
    """Returns a relation, on its follower: in Newton's words between dofs of the same kind, in PhysX's
    between any. `axes`: the axes of the follower's and of the driver's joint."""
    scale, least = units(follower)
    multiplier = relation.multiplier * scale / units(driver)[0]
    offset = _rounded(relation.offset * scale, least)
    newton = JointFacts()
    if follower.kind == driver.kind:
        coefficients = {"newton:mimicCoef0": offset, "newton:mimicCoef1": multiplier}
        newton = JointFacts(("NewtonMimicAPI",), coefficients, {}, {"newton:mimicJoint": driver.name})
    # PhysX: position + gearing · reference + offset = 0.
    follower_axis, driver_axis = (f"rot{axis}" for axis in axes)
    prefix = f"physxMimicJoint:{follower_axis}:"
    return newton | JointFacts(
        (f"PhysxMimicJointAPI:{follower_axis}",),
        {f"{prefix}gearing": -multiplier, f"{prefix}offset": -offset},
        {f"{prefix}referenceJointAxis": driver_axis},
        {f"{prefix}referenceJoint": driver.name},
    )


def _rounded(value: float, least: float) -> float:
    """Rounds a number as the other formats do; `least`: the smallest scale (see `formats.numbers`)."""
    return float(number(value, least=least))
