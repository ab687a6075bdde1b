"""What a joint of a USD says beside its bodies, frames and limits: resistance, state, drive and relations, in
the words of UsdPhysics, of PhysX and of Newton.

UsdPhysics has angles in degrees, and so have both engines' own attributes: what is for each radian is π/180
of it for each degree.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from linkwright.stages.formats.numbers import LENGTH, TURN, number
from linkwright.stages.formats.usd.drives import Drive
from linkwright.stages.robot.model.robot import Dof, Relation

DEGREES = 180.0 / math.pi


@dataclass(frozen=True, slots=True)
class JointFacts:
    """Applied schemas, and by name attributes that are numbers, those that are words, and relationships to
    the joint of another dof."""

    schemas: tuple[str, ...] = ()
    numbers: Mapping[str, float] = field(default_factory=dict)
    words: Mapping[str, str] = field(default_factory=dict)
    targets: Mapping[str, str] = field(default_factory=dict)

    def __or__(self, other: "JointFacts") -> "JointFacts":
        return JointFacts(
            (*self.schemas, *other.schemas),
            {**self.numbers, **other.numbers},
            {**self.words, **other.words},
            {**self.targets, **other.targets},
        )


def units(dof: Dof) -> tuple[float, float]:
    """What a value of a turn or a slide is in USD's unit, degrees or metres, and what it is measured by
    there."""
    return (DEGREES, TURN * DEGREES) if dof.kind == "turn" else (1.0, LENGTH)


def drive_name(dof: Dof) -> str:
    """What UsdPhysics calls the one degree of freedom of a joint."""
    return "angular" if dof.kind == "turn" else "linear"


def resistance(dof: Dof) -> JointFacts:
    """Armature, damping, friction and largest speed, in Newton's attributes and both PhysX's."""
    dynamics = dof.dynamics
    scale = 1.0 if dof.kind == "slide" else DEGREES
    damping, velocity = dynamics.damping, dynamics.velocity
    found = {
        "armature": dynamics.armature,
        "damping": None if damping is None else damping / scale,
        "friction": dynamics.friction,
        "velocityLimit": None if velocity is None else velocity * scale,
    }
    given = {name: value for name, value in found.items() if value is not None}
    if not given:
        return JointFacts()
    schemas, numbers = ["NewtonJointAPI"], {f"newton:{name}": value for name, value in given.items()}
    known = {"armature": "armature", "velocityLimit": "maxJointVelocity"}
    if given.keys() & known.keys():
        schemas.append("PhysxJointAPI")
        numbers |= _renamed(given, known, "physxJoint:")
    if dof.kind == "ball":
        return JointFacts(tuple(schemas), numbers)
    known |= {"damping": "viscousFrictionCoefficient"}
    schemas.append(f"PhysxJointAxisAPI:{drive_name(dof)}")
    before = f"physxJointAxis:{drive_name(dof)}:"
    numbers |= _renamed(given, known, before)
    if "friction" in given:
        for own in ("staticFrictionEffort", "dynamicFrictionEffort"):
            numbers[f"{before}{own}"] = given["friction"]
    return JointFacts(tuple(schemas), numbers)


def _renamed(given: Mapping[str, float], known: Mapping[str, str], before: str) -> dict[str, float]:
    return {f"{before}{own}": given[name] for name, own in known.items() if name in given}


def state(dof: Dof, value: float) -> JointFacts:
    """Where a turn or a slide is [rad or m]."""
    scale, least = units(dof)
    position = {f"state:{drive_name(dof)}:physics:position": _rounded(value * scale, least)}
    return JointFacts((f"PhysicsJointStateAPI:{drive_name(dof)}",), position)


def driven(dof: Dof, drive: Drive) -> JointFacts:
    """What drives a turn or a slide."""
    scale, least = units(dof)
    before = f"drive:{drive_name(dof)}:physics:"
    numbers = {f"{before}stiffness": drive.stiffness / scale, f"{before}damping": drive.damping / scale}
    if drive.force is not None:
        numbers[f"{before}maxForce"] = drive.force
    numbers[f"{before}targetPosition"] = _rounded(drive.target * scale, least)
    return JointFacts((f"PhysicsDriveAPI:{drive_name(dof)}",), numbers, {f"{before}type": "force"})


def mimic(relation: Relation, follower: Dof, driver: Dof, axes: tuple[str, str]) -> JointFacts:
    """A relation, on its follower: in Newton's words between two of one kind, in PhysX's of any. `axes`: the
    axes of the follower's and of the driver's joint."""
    scale, least = units(follower)
    multiplier = relation.multiplier * scale / units(driver)[0]
    offset = _rounded(relation.offset * scale, least)
    newton = JointFacts()
    if follower.kind == driver.kind:
        coefficients = {"newton:mimicCoef0": offset, "newton:mimicCoef1": multiplier}
        newton = JointFacts(("NewtonMimicAPI",), coefficients, {}, {"newton:mimicJoint": driver.name})
    # PhysX: position + gearing · reference + offset = 0.
    own, other = (f"rot{axis}" for axis in axes)
    before = f"physxMimicJoint:{own}:"
    return newton | JointFacts(
        (f"PhysxMimicJointAPI:{own}",),
        {f"{before}gearing": -multiplier, f"{before}offset": -offset},
        {f"{before}referenceJointAxis": other},
        {f"{before}referenceJoint": driver.name},
    )


def _rounded(value: float, least: float) -> float:
    return float(number(value, least=least))
