"""Lists losses of joints, their drives, and loops."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.losses.loss import Loss
from linkwright.stages.export.urdf.lowering import lower, unset_limits
from linkwright.stages.export.writer import Case
from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.urdf.names import urdf_names, urdf_steps
from linkwright.stages.formats.usd.zeros import is_turned
from linkwright.stages.robot.dynamics.inertia import TINY_MASS
from linkwright.stages.robot.model.robot import Dof, Joint, Loop, Value
from linkwright.stages.robot.motion.linear_coupling import LinearCoupling

if TYPE_CHECKING:
    from linkwright.stages.export.sdf.model import SdfPlan
    from linkwright.stages.export.usd.model import UsdPlan

_SMALL_LINKS = f"links of {number(TINY_MASS)} kg between them"


def _urdf_chains(case: Case[Any]) -> Iterator[str]:
    for item in lower(case.robot, [joint for joint in case.robot.joints if urdf_steps(joint) > 1]):
        yield f"{item.joint.name} ({item.joint.type}: {', '.join(part.name for part in item.joints)})"


def _chains(case: Case[Any]) -> Iterator[str]:
    """Yields the joints of several degrees of freedom, also in loops. A USD may have general joints
    instead."""
    names = case.plan.names.joints
    general = {joint.name for joint in case.plan.joints if not joint.type} if case.format == "usd" else ()
    joints: list[Joint | Loop] = [*case.robot.joints, *case.robot.loops]
    for joint in joints:
        if len(joint.dofs) > 1 and names.get(joint.name) not in general:
            role = ", of a loop" if case.format == "usd" and isinstance(joint, Loop) else ""
            yield f"{joint.name} ({joint.type}{role}: {', '.join(names[dof.name] for dof in joint.dofs)})"


def _balls(case: Case[Any]) -> list[Dof]:
    """Returns the dofs of ball joints, which in an SDF include those of loops."""
    loops = case.robot.loops if case.format == "sdf" else ()
    joints: list[Joint | Loop] = [*case.robot.joints, *loops]
    return [dof for joint in joints for dof in joint.dofs if dof.kind == "ball"]


def _limited_balls(case: Case[Any]) -> list[str]:
    return [dof.name for dof in _balls(case) if dof.limits.upper is not None]


def _damped_balls(case: Case[Any]) -> Iterator[str]:
    for dof in _balls(case):
        dynamics = dof.dynamics
        if dynamics.damping or dynamics.friction or dynamics.effort or dynamics.velocity:
            yield dof.name


def _ball_efforts(case: Case[Any]) -> list[str]:
    return [dof.name for dof in _balls(case) if dof.dynamics.effort is not None]


def _mjcf_ball_zeros(case: Case[Any]) -> Iterator[str]:
    for dof in _balls(case):
        angle = _angle(case.written.start[dof.name])
        # Below this angle [deg] is only rounding.
        yield f"{dof.name} ({f'{angle:.4g} deg apart' if angle > 1e-9 else 'the same'})"


def _sdf_zeros(case: "Case[SdfPlan]") -> Iterator[str]:
    tree_dofs = {dof.name for joint in case.robot.joints if joint.type != "free" for dof in joint.dofs}
    for name, value in case.plan.lowered.nonzero_values.items():
        if name in tree_dofs:
            is_ball = isinstance(value, tuple)
            yield f"{name} ({f'turned by {_angle(value):.4g} deg' if is_ball else f'{value:.6g}'})"


def _usd_ball_starts(case: "Case[UsdPlan]") -> Iterator[str]:
    for dof in _balls(case):
        if dof.name not in case.plan.ball_zeros and is_turned(case.plan.home[dof.name]):
            yield dof.name


def _angle(turn: Value) -> float:
    """Returns the angle of a quaternion [deg]."""
    assert isinstance(turn, tuple)
    return math.degrees(2.0 * math.atan2(math.hypot(*turn[1:]), abs(turn[0])))


def free_joints(case: Case[Any]) -> list[str]:
    return [joint.name for joint in case.robot.joints if joint.type == "free"]


def _armatures(case: Case[Any]) -> list[str]:
    return [dof.name for dof in case.robot.dofs if dof.dynamics.armature]


def _unset_limits(case: Case[Any]) -> Iterator[str]:
    for dof in case.robot.dofs:
        if keys := unset_limits(dof):
            yield f"{dof.name}: {', '.join(keys)}"


def _renamed_frames(case: Case[Any]) -> Iterator[str]:
    for frame, name in urdf_names(case.robot).frames.items():
        if name != frame:
            yield f"the frame {frame!r} is named {name!r}"


def _urdf_loops(case: Case[Any]) -> Iterator[str]:
    loops, form = case.written.robot.loops, case.written.urdf_form
    if not loops:
        return
    yield "URDF has no loops"
    if form.closed:
        yield f"closed by <mimic> joints alone: {', '.join(form.closed)}"
    if form.mimics:
        yield f"exact along the loops: {'; '.join(map(_equation, form.mimics))}"
    if names := [loop.name for loop in loops if loop.name not in form.closed]:
        yield f"open, with a frame on either side (<name>_a, <name>_b): {', '.join(names)}"
    inexact = [coupling for coupling in form.couplings if not coupling.exact]
    if approximations := [
        f"{_equation(coupling)}, off by up to {coupling.error:.2g}" for coupling in inexact
    ]:
        yield f"not linear, so the best line is no <mimic>: {'; '.join(approximations)}"


def _equation(coupling: LinearCoupling) -> str:
    """Returns a coupling as an equation."""
    offset = coupling.offset
    shift = "" if abs(offset) < 1e-6 else f" {'-' if offset < 0 else '+'} {abs(offset):.6g}"
    return f"{coupling.follower} = {coupling.multiplier:.6g} {coupling.driver}{shift}"


def _mixed_relations(case: Case[Any]) -> Iterator[str]:
    kinds = {dof.name: dof.kind for dof in case.robot.dofs}
    for relation in case.robot.relations:
        if kinds[relation.follower] != kinds[relation.driver]:
            yield relation.follower


def _reduced_drives(case: "Case[UsdPlan]") -> list[str]:
    drives = case.plan.drives
    return [*drives.left_out, *(f"{name} (without its {lack})" for name, lack in drives.losses)]


def _urdf_merged(case: Case[Any]) -> Iterator[str]:
    for link, (holder, _) in case.written.as_urdf.held.items():
        if link != holder:
            yield f"{link} into {holder}"


JOINTS = (
    Loss(
        {"urdf": "I-URDF-LOWERED"},
        _urdf_chains,
        "a URDF joint has one degree of freedom, so each of these becomes several joints, with "
        f"{_SMALL_LINKS}: {{}}",
        "the MJCF needs no such links; robot.json lists them under lowered",
        "; ".join,
    ),
    Loss(
        {"sdf": "I-SDF-LOWERED", "usd": "I-USD-LOWERED"},
        _chains,
        f"each of these becomes several joints in the {{format}}, with {_SMALL_LINKS}: {{}}",
        "the MJCF needs no such links",
        "; ".join,
    ),
    Loss(
        {"usd": "I-USD-LOOP"},
        lambda case: [loop.name for loop in case.robot.loops],
        "PhysX (Isaac Sim) closes loops by joints outside its articulation, which does not work for every "
        "loop: these may jump at the start, or fly apart: {}",
        "try it there with armature and damping on the joints; MuJoCo closes the loops of the MJCF",
    ),
    Loss(
        {"mjcf": "W-BALL-CONE"},
        _limited_balls,
        "MuJoCo's range of a ball joint limits its twist too, which a cone does not, so the MJCF has no "
        "limit for: {}",
        "enforce the cone in the controller: robot.json has its half angle",
    ),
    Loss(
        {"urdf": "W-BALL-CONE", "sdf": "W-BALL-CONE"},
        _limited_balls,
        "{format} cannot limit the tilt of a ball joint, so these tilt freely: {}",
        "enforce the cone in the controller: robot.json has its half angle",
    ),
    Loss(
        {"mjcf": "W-BALL-EFFORT"},
        _ball_efforts,
        "MuJoCo limits the force of hinges and slides only, so the MJCF has no effort limit for: {}",
        "limit the effort in the controller: robot.json has its value",
    ),
    Loss(
        {"sdf": "I-SDF-BALL"},
        _damped_balls,
        "SDF has no damping, friction, effort and velocity for ball joints, so these joints lose theirs: {}",
        "use the MJCF where they matter",
    ),
    Loss(
        {"mjcf": "I-BALL-ZERO"},
        _mjcf_ball_zeros,
        "a ball joint's q = 0 is its pose at qpos0 in the MJCF, and its mate's zero in the URDF: {}",
        "robot.json has both, under zero of the dof",
    ),
    Loss(
        {"sdf": "I-SDF-ZERO"},
        _sdf_zeros,
        "an SDF counts joint values from the pose of its links, in which the loops are closed, so these "
        "joints have the value 0 in the SDF at the value listed here: {}",
        "add it to a value of the SDF; its limits and mimics include it already",
    ),
    Loss(
        {"usd": "I-USD-ZERO"},
        lambda case: case.plan.ball_zeros,
        "engines start ball joints at their zero, so in the USD the zero of these balls is their pose at "
        "`home`: {}",
        "robot.json has that pose (usd.zeros): values of the USD's joints count from there",
    ),
    Loss(
        {"usd": "I-USD-START"},
        _usd_ball_starts,
        "engines start ball joints at their zero, which is in the middle of the cone, so these do not start "
        "at `home`: {}",
        "let the controller turn them, or remove the cone: `joints: {NAME: {limits: [null, null]}}`",
    ),
    Loss(
        {"urdf": "I-URDF-FREE"},
        free_joints,
        "many URDF readers ignore joints of type floating, or fix them: {}",
        "use the MJCF where these links must move; of a URDF, MuJoCo accepts a floating joint only below a "
        "root link named world",
    ),
    Loss(
        {"sdf": "I-SDF-MIMIC"},
        lambda case: [case.plan.names.joints[relation.follower] for relation in case.robot.relations],
        "readers before SDF 1.11 (Gazebo Harmonic) ignore <mimic>, so there these move freely: {}",
        "use Gazebo Harmonic or newer with its engine bullet-featherstone, or the MJCF",
    ),
    Loss(
        {"usd": "I-USD-MIMIC"},
        _mixed_relations,
        "Newton has no relation between a turn and a slide, so there these move freely, or wrongly if it "
        "reads the attributes of PhysX: {}",
        "PhysX (Isaac Sim) has the relation; for Newton use the MJCF",
    ),
    Loss(
        {"usd": "I-USD-ACTUATOR"},
        _reduced_drives,
        "a drive of UsdPhysics is a spring and a damper with a maximum force, so these actuators are left "
        "out or reduced to that: {}",
        "do the rest in the controller, or use the MJCF",
    ),
    Loss(
        {"usd": "I-USD-GRAVITY"},
        lambda case: [link for link, _ in case.written.actuation.compensated],
        "USD cannot let actuators hold a share of a link's weight, so these links have their full weight: {}",
        "compensate gravity in the controller, or use the MJCF",
    ),
    Loss(
        {"usd": "I-USD-BALL"},
        _ball_efforts,
        "a ball joint of UsdPhysics has no maximum torque, so these joints lose theirs: {}",
        "enforce it in the controller: robot.json has it",
    ),
    Loss(
        {"urdf": "I-URDF-ARMATURE", "sdf": "I-SDF-ARMATURE"},
        _armatures,
        "{format} has no armature (rotor inertia), so it is left out of these joints: {}",
        "use the MJCF, or armature in robot.json",
    ),
    Loss(
        {"urdf": "I-URDF-UNSET"},
        _unset_limits,
        "URDF requires limits, efforts and velocities that are not set, so defaults were written (effort "
        "100, velocity 10, ±1 m, ±2π rad): {}",
        'set them: joints: {"*": {effort: ..., velocity: ...}}',
        "; ".join,
    ),
    Loss(
        {"urdf": "I-URDF-NAME"},
        _renamed_frames,
        "{} in the URDF, since a link has its name",
        "the MJCF keeps the name; robot.json has the URDF's name, under urdf",
        None,
    ),
    Loss(
        {"urdf": "I-URDF-LOOP"},
        _urdf_loops,
        "{}",
        "the MJCF closes them; robot.json has them under loops, and what follows what under couplings",
        ". ".join,
    ),
    Loss(
        {"urdf": "I-URDF-MERGED"},
        _urdf_merged,
        "links on fixed joints are merged: {}",
        "robot.json has the place of each, under merged; to keep a link there, put a frame on it",
    ),
)
