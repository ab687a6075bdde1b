"""Reports what SDF cannot express: one diagnostic for each kind of loss."""

import math
from collections.abc import Iterator

from linkwright.stages.export.sdf.contacts import BITS, LOW
from linkwright.stages.export.sdf.model import SdfPlan
from linkwright.stages.formats.numbers import number
from linkwright.stages.robot.dynamics.inertia import NEXT_TO_NOTHING
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Joint, Loop, Robot, Value
from linkwright.stages.robot.text.globs import listed


def unsupported(
    robot: Robot, geometry: Geometry, actuation: Actuation, plan: SdfPlan
) -> Iterator[Diagnostic]:
    """A diagnostic for each kind of loss that this robot has."""
    file = f"{robot.name}.sdf"
    yield from _joints(robot, plan, file)
    yield from _values(robot, plan, file)
    yield from _contacts(geometry, plan, file)
    yield from _apart(robot, actuation, plan, file)


def _joints(robot: Robot, plan: SdfPlan, file: str) -> Iterator[Diagnostic]:
    chains: list[Joint | Loop] = [*robot.joints, *robot.loops]
    several = [
        f"{one.name} ({one.type}: {', '.join(plan.names.joints[dof.name] for dof in one.dofs)})"
        for one in chains
        if len(one.dofs) > 1
    ]
    if several:
        yield Diagnostic(
            "I-SDF-LOWERED",
            "each of these is several joints in the SDF, with links of "
            f"{number(NEXT_TO_NOTHING)} kg between them: " + "; ".join(several),
            file,
            "the MJCF needs no such links",
        )
    balls = [dof for one in chains for dof in one.dofs if dof.kind == "ball"]
    cones = [dof.name for dof in balls if dof.limits.upper is not None]
    if cones:
        yield Diagnostic(
            "W-BALL-CONE",
            f"SDF cannot limit the tilt of a ball joint, so these tilt freely: {', '.join(cones)}",
            file,
            "enforce the cone in the controller: robot.json has its half angle",
        )
    damped = [
        dof.name
        for dof in balls
        if dof.dynamics.damping or dof.dynamics.friction or dof.dynamics.effort or dof.dynamics.velocity
    ]
    if damped:
        yield Diagnostic(
            "I-SDF-BALL",
            "SDF has no damping, friction, effort and velocity of a ball joint, so these have none: "
            + ", ".join(damped),
            file,
            "use the MJCF where they matter",
        )


def _values(robot: Robot, plan: SdfPlan, file: str) -> Iterator[Diagnostic]:
    own = {dof.name for joint in robot.joints if joint.type != "free" for dof in joint.dofs}
    moved = [f"{name} ({_shown(value)})" for name, value in plan.lowered.moved.items() if name in own]
    if moved:
        yield Diagnostic(
            "I-SDF-ZERO",
            "an SDF counts its joints from where its links stand, which is where the loops are closed, so "
            f"these joints are at 0 in the SDF at the value given here: {', '.join(moved)}",
            file,
            "add it to a value of the SDF; limits and mimics are counted so already",
        )
    if robot.relations:
        names = [plan.names.joints[relation.follower] for relation in robot.relations]
        yield Diagnostic(
            "I-SDF-MIMIC",
            f"readers before SDF 1.11 (Gazebo Harmonic) ignore <mimic>, so there these move freely: "
            f"{', '.join(names)}",
            file,
            "use a Gazebo from Harmonic on with its engine bullet-featherstone, or the MJCF",
        )
    rotors = [dof.name for dof in robot.dofs if dof.dynamics.armature]
    if rotors:
        yield Diagnostic(
            "I-SDF-ARMATURE",
            f"SDF has no armature (rotor inertia), so it is left out of these joints: {', '.join(rotors)}",
            file,
            "use the MJCF, or armature in robot.json",
        )


def _contacts(geometry: Geometry, plan: SdfPlan, file: str) -> Iterator[Diagnostic]:
    lost = {}
    for shape in geometry.shapes:
        if shape.contact is not None and shape.role == "collision":
            keys = [key for key in shape.contact.given() if key != "friction"]
            friction = shape.contact.friction
            if friction is not None and any(friction[1:]):
                keys.insert(0, "friction (torsional, rolling)")
            if keys:
                lost[shape.link] = keys
    if lost:
        yield Diagnostic(
            "I-SDF-CONTACT",
            "SDF has no such properties of contact, so these are left out: "
            + "; ".join(f"{link}: {', '.join(keys)}" for link, keys in lost.items()),
            file,
            "use the MJCF",
        )
    if geometry.self_contact and not plan.contacts.collides:
        yield Diagnostic(
            "I-SDF-SELF",
            f"{LOW} bits of a mask do not suffice for the pairs of links that must not collide, so the SDF's "
            "links do not collide with each other at all",
            file,
            "use the MJCF where they must",
        )
    if plan.contacts.lost:
        pairs = listed(f"{one} and {other}" for one, other in plan.contacts.lost)
        yield Diagnostic(
            "I-SDF-SELF",
            f"{BITS} bits of a mask do not suffice to keep only those links from colliding that must not, so "
            f"these do not collide either: {pairs}",
            file,
            "use the MJCF where they must",
        )


def _apart(robot: Robot, actuation: Actuation, plan: SdfPlan, file: str) -> Iterator[Diagnostic]:
    driven = [one.name for one in actuation.actuators]
    if driven:
        yield Diagnostic(
            "I-SDF-ACTUATOR",
            f"SDF has no actuators, so these are left out: {', '.join(driven)}",
            file,
            "a controller of Gazebo (JointPositionController, ros2_control) drives its joints",
        )
    if plan.sensors.left_out:
        yield Diagnostic(
            "I-SDF-SENSOR",
            f"SDF has no such sensors, so these are left out: {', '.join(plan.sensors.left_out)}",
            file,
            "Gazebo publishes the states of joints and the poses of links by systems of its own",
        )
    aside = [one.name for one in plan.sensors.mounted if one.aside]
    if aside:
        yield Diagnostic(
            "I-SDF-TORQUE",
            "SDF measures torques about the origin of the joint above, in the axes of the sensor, so these, "
            f"which are elsewhere on their links, measure others than in the MJCF: {', '.join(aside)}",
            file,
            "the torque about the sensor is the SDF's less (sensor − joint) × force; forces are the same",
        )
    changed = [f"the {kind} {name!r} is {own!r}" for kind, name, own in plan.names.changed]
    if changed:
        yield Diagnostic(
            "I-SDF-NAME",
            "links, joints and frames share one space of names in an SDF, and some names are reserved there: "
            + ", ".join(changed),
            file,
            "the other formats keep the names",
        )


def _shown(value: Value) -> str:
    if not isinstance(value, tuple):
        return f"{value:.6g}"
    angle = 2.0 * math.atan2(math.hypot(*value[1:]), abs(value[0]))
    return f"turned by {math.degrees(angle):.4g} deg"
