"""Reports what a USD cannot express: one diagnostic for each kind of loss."""

from collections.abc import Iterator

from linkwright.stages.export.usd.model import UsdPlan
from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.usd.zeros import is_turned
from linkwright.stages.robot.dynamics.inertia import NEXT_TO_NOTHING
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.start_pose import HOME


def unsupported(
    robot: Robot, geometry: Geometry, actuation: Actuation, plan: UsdPlan
) -> Iterator[Diagnostic]:
    """A diagnostic for each kind of loss that this robot has."""
    file = f"{robot.name}.usda"
    yield from _joints(robot, plan, file)
    yield from _driven(robot, actuation, plan, file)
    yield from _contacts(geometry, file)
    yield from _apart(robot, plan, file)


def _joints(robot: Robot, plan: UsdPlan, file: str) -> Iterator[Diagnostic]:
    several = [
        f"{one.name} ({one.type}: {', '.join(plan.names.joints[dof.name] for dof in one.dofs)})"
        for one in robot.joints
        if len(one.dofs) > 1
    ]
    general = {joint.name for joint in plan.joints if not joint.type}
    several += [
        f"{one.name} ({one.type}, of a loop: {', '.join(plan.names.joints[dof.name] for dof in one.dofs)})"
        for one in robot.loops
        if len(one.dofs) > 1 and plan.names.joints[one.name] not in general
    ]
    if several:
        yield Diagnostic(
            "I-USD-LOWERED",
            "each of these is several joints in the USD, with links of "
            f"{number(NEXT_TO_NOTHING)} kg between them: " + "; ".join(several),
            file,
            "the MJCF needs no such links",
        )
    if robot.loops:
        yield Diagnostic(
            "I-USD-LOOP",
            "PhysX (Isaac Sim) holds loops by joints outside of its articulation, and not every loop: these "
            f"may jump at the start, or fly apart: {', '.join(one.name for one in robot.loops)}",
            file,
            "try it there with armature and damping on the joints; MuJoCo holds the loops of the MJCF",
        )
    yield from _balls(robot, plan, file)
    kinds = {dof.name: dof.kind for dof in robot.dofs}
    mixed = [one.follower for one in robot.relations if kinds[one.follower] != kinds[one.driver]]
    if mixed:
        yield Diagnostic(
            "I-USD-MIMIC",
            "Newton has no relation between a turn and a slide, so there these move freely, or wrongly where "
            f"it is given the attributes of PhysX: {', '.join(mixed)}",
            file,
            "PhysX (Isaac Sim) has the relation; for Newton use the MJCF",
        )


def _balls(robot: Robot, plan: UsdPlan, file: str) -> Iterator[Diagnostic]:
    if plan.zeros:
        yield Diagnostic(
            "I-USD-ZERO",
            "engines start ball joints at their zero, so the joints of these are there where the balls are "
            f"at `home`: {', '.join(plan.zeros)}",
            file,
            "robot.json has that pose (usd.zeros): a joint of the USD turns on from there",
        )
    balls = [dof.name for dof in robot.dofs if dof.kind == "ball" and dof.name not in plan.zeros]
    off = [name for name in balls if is_turned(plan.home[name])]
    if off:
        yield Diagnostic(
            "I-USD-START",
            "engines start ball joints at their zero, which is in the middle of the cone, so these do not "
            f"begin at `home`: {', '.join(off)}",
            file,
            "let the controller turn them, or give them no cone: `joints: {NAME: {limits: [null, null]}}`",
        )


def _driven(robot: Robot, actuation: Actuation, plan: UsdPlan, file: str) -> Iterator[Diagnostic]:
    drives = plan.drives
    if drives.left_out or drives.less:
        words = [*drives.left_out, *(f"{name} (without its {what})" for name, what in drives.less)]
        yield Diagnostic(
            "I-USD-ACTUATOR",
            "a drive of UsdPhysics is a spring and a damper with a largest force, so these are left out, or "
            f"are less than they were: {', '.join(words)}",
            file,
            "do the rest in the controller, or use the MJCF",
        )
    if actuation.compensated:
        yield Diagnostic(
            "I-USD-GRAVITY",
            "USD has no share of a link's weight that actuators hold, so these links have all of theirs: "
            + ", ".join(link for link, _ in actuation.compensated),
            file,
            "let the controller hold it, or use the MJCF",
        )
    balls = [dof.name for dof in robot.dofs if dof.kind == "ball" and dof.dynamics.effort is not None]
    if balls:
        yield Diagnostic(
            "I-USD-BALL",
            f"a ball joint of UsdPhysics has no largest torque, so these have none: {', '.join(balls)}",
            file,
            "enforce it in the controller: robot.json has it",
        )


def _contacts(geometry: Geometry, file: str) -> Iterator[Diagnostic]:
    lost = {}
    for shape in geometry.shapes:
        if shape.contact is not None and shape.role == "collision":
            keys = [key for key in shape.contact.given() if key != "friction"]
            if keys:
                lost[shape.link] = keys
    if lost:
        yield Diagnostic(
            "I-USD-CONTACT",
            "USD has no such properties of contact, so these are left out: "
            + "; ".join(f"{link}: {', '.join(keys)}" for link, keys in lost.items()),
            file,
            "use the MJCF",
        )


def _apart(robot: Robot, plan: UsdPlan, file: str) -> Iterator[Diagnostic]:
    if plan.sensing.sensors:
        yield Diagnostic(
            "I-USD-SENSOR",
            "USD has no sensors but cameras, so these are left out: "
            + ", ".join(one.name for one in plan.sensing.sensors),
            file,
            "their places are Xforms of the links: add the sensors of Isaac Sim or Newton there",
        )
    poses = [one.name for one in robot.keyframes if one.name != HOME]
    if poses:
        yield Diagnostic(
            "I-USD-KEYFRAME",
            f"a USD has one pose, which is `home`, so these are left out: {', '.join(poses)}",
            file,
            "the MJCF has them as keyframes",
        )
    changed = [f"the {kind} {name!r} is {own!r}" for kind, name, own in plan.names.changed]
    if changed:
        yield Diagnostic(
            "I-USD-NAME",
            "a name in a USD has letters of ASCII, digits and _ alone, and no digit first: "
            + ", ".join(changed),
            file,
            "the prim shows the name as it was (displayName)",
        )
