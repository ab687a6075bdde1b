"""Checks that the robot rests with the controls of `home`: its actuators hold it, and it does not fall over.

Its result is a warning: a robot that balances, or that has a joint without a drive, need not rest. Where
nothing in the world can carry a free robot, as in space, it falls, and only its joints are judged.
"""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.trial import MAX_WORK, failure
from linkwright.stages.mujoco.warnings import collected_warnings
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named, named_joint
from linkwright.stages.validate.model.coordinates import FREE, HINGE, SLIDE, bodies_of_scene

SECONDS = 2.0
"""Length of the run [s]."""

MAX_SAG, MAX_SLIP = 0.1, 0.02
"""Largest angle [rad] and distance [m] by which a joint may sag, or a base tilt and sink, until the servos
hold the weight."""

MAX_SPEED = 0.1
"""Largest speed [rad/s, m/s] of a robot at rest, at the end of the run."""

JOINT_TRANSMISSIONS = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
"""Kinds of transmission of the actuators that drive a joint directly."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Runs models with actuators. Yields nothing if the run fails, which the trial run reports."""
    model = compiled.model
    motions = largest_motions(compiled)
    if motions is None:
        return
    excessive = [motion for motion in motions if motion[0] > 1.0]
    share, worst, words = motions[0] if motions else (0.0, -1, "")
    name = model.joint(worst).name or named_joint(model, worst) if worst >= 0 else ""
    time = _steps(model) * model.opt.timestep
    controlled = f"{time:.3g} s with the controls of home"
    detail = f"{controlled}; the largest motion, as a share of what is allowed: {name} {words}"
    findings = [_finding(model, joint, words) for _, joint, words in excessive]
    yield compiled.result("rests at home", not excessive, detail, share, 1.0, findings, "warning")


def largest_motions(compiled: CompiledModel) -> list[tuple[float, int, str]] | None:
    """Returns the motion of each judged joint as (share of the allowed motion, index of the joint, text), the
    largest first. Returns None without actuators, or if the run fails, which the trial run reports."""
    model = compiled.model
    if not model.nu or not model.nq:
        return None
    data = at_keyframe(model)
    start = data.qpos.copy()
    with collected_warnings():
        mujoco.mj_step(model, data, _steps(model))
    if failure(model, data):
        return None
    joints = _judged_joints(compiled)
    motions = (motion for joint in joints for motion in _motions(model, data, start, joint))
    return sorted(motions, reverse=True)


def _steps(model: Any) -> int:
    """Returns the number of steps of the run; fewer than `SECONDS` need for a large model (`MAX_WORK`)."""
    steps = round(SECONDS / float(model.opt.timestep))
    return max(1, min(steps, int(MAX_WORK / max(1, model.nv) ** 2)))


def _judged_joints(compiled: CompiledModel) -> list[int]:
    """Returns the robot's joints. The joints of other objects are left out, since a ball may roll, and so is
    a free base that falls because nothing carries it."""
    model = compiled.model
    scene_bodies = bodies_of_scene(model, compiled.robot)
    joints = [joint for joint in range(model.njnt) if int(model.jnt_bodyid[joint]) not in scene_bodies]
    return [joint for joint in joints if model.jnt_type[joint] != FREE or _has_ground(model)]


def _has_ground(model: Any) -> bool:
    """Tells whether something fixed in the world collides."""
    fixed = model.body_weldid[model.geom_bodyid] == 0
    return bool(np.any(fixed & ((model.geom_contype | model.geom_conaffinity) != 0)))


def _motions(model: Any, data: Any, start: Any, joint: int) -> Iterator[tuple[float, int, str]]:
    """Yields (share of the allowed motion, index of the joint, text) for the change of a joint's value and
    for its speed."""
    at, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    kind = mujoco.mjtJoint(model.jnt_type[joint])
    if kind in (HINGE, SLIDE):
        change, speed = abs(float(data.qpos[at] - start[at])), abs(float(data.qvel[dof]))
        unit = "rad" if kind == HINGE else "m"
        yield change / (MAX_SAG if kind == HINGE else MAX_SLIP), joint, f"moved by {change:.2g} {unit}"
        yield speed / MAX_SPEED, joint, f"still moves at {speed:.2g} {unit}/s"
        return
    if kind == FREE:
        change = float(np.linalg.norm(data.qpos[at : at + 3] - start[at : at + 3]))
        yield change / MAX_SLIP, joint, f"moved by {change:.2g} m"
        at += 3
    rotation_vector = np.zeros(3)
    mujoco.mju_subQuat(rotation_vector, data.qpos[at : at + 4].copy(), start[at : at + 4].copy())
    angle = float(np.linalg.norm(rotation_vector))
    yield angle / MAX_SAG, joint, f"turned by {angle:.2g} rad"


def _finding(model: Any, joint: int, words: str) -> Finding:
    name = model.joint(joint).name
    # The number of a target is that of a joint only for some kinds of transmission.
    on_joint = np.isin(model.actuator_trntype, JOINT_TRANSMISSIONS)
    drivers = np.flatnonzero(on_joint & (model.actuator_trnid[:, 0] == joint)).tolist()
    if model.jnt_type[joint] == FREE:
        return Finding(
            named_joint(model, joint), "", f"the base {words}: it does not stand at home by itself"
        )
    if drivers:
        actuator = model.actuator(drivers[0]).name
        return Finding(
            named("actuator", actuator),
            "ctrl of the keyframe home",
            f"{name} {words}: it does not hold the joint",
        )
    return Finding(named_joint(model, joint), "", f"it {words}, and nothing drives it")
