"""With the controls of `home`, the robot stays there: its actuators hold it, and it does not fall over.

A warning: a robot that balances, or that has a joint that nothing drives, need not. Where nothing in the
world can carry it, as in space, a free robot falls, and only its joints are judged.
"""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.trial import EFFORT, failure
from linkwright.stages.mujoco.warnings import listening
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named, named_joint
from linkwright.stages.validate.model.coordinates import FREE, HINGE, SLIDE, of_the_scene

SECONDS = 2.0
"""The length of the run."""

TURN, SLIP = 0.1, 0.02
"""A joint may sag so far [rad, m], and a base sink or tilt, until its servos hold the weight."""

SPEED = 0.1
"""At the end it moves more slowly than this [rad/s, m/s]."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """None without actuators."""
    model = compiled.model
    if not model.nu or not model.nq:
        return
    data = at_keyframe(model)
    start = data.qpos.copy()
    steps = round(SECONDS / model.opt.timestep)
    with listening():
        mujoco.mj_step(model, data, max(1, min(steps, int(EFFORT / max(1, model.nv) ** 2))))
    if failure(model, data):
        return  # the trial run says so
    judged = _judged(compiled)
    moved = sorted((one for joint in judged for one in _moved(model, data, start, joint)), reverse=True)
    far = [one for one in moved if one[0] > 1.0]
    share, worst, words = moved[0] if moved else (0.0, -1, "")
    name = model.joint(worst).name or named_joint(model, worst) if worst >= 0 else ""
    detail = (
        f"{data.time:.3g} s with the controls of home; the most, as a share of what may be: {name} {words}"
    )
    findings = [_finding(model, joint, words) for _, joint, words in far]
    yield compiled.result("rests at home", not far, detail, share, 1.0, findings, "warning")


def _judged(compiled: CompiledModel) -> list[int]:
    """The joints but for those of what lies beside the robot, since a ball may roll, and for a free base that
    falls since nothing is there to stand on."""
    model = compiled.model
    beside = of_the_scene(model, compiled.robot)
    own = [one for one in range(model.njnt) if int(model.jnt_bodyid[one]) not in beside]
    return [one for one in own if model.jnt_type[one] != FREE or _carried(model)]


def _carried(model: Any) -> bool:
    """Whether something that stands in the world collides."""
    stands = model.body_weldid[model.geom_bodyid] == 0
    return bool(np.any(stands & ((model.geom_contype | model.geom_conaffinity) != 0)))


def _moved(model: Any, data: Any, start: Any, joint: int) -> Iterator[tuple[float, int, str]]:
    """(how far as a share of what is allowed, index of the joint, in words) of its value and of its speed."""
    at, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    kind = mujoco.mjtJoint(model.jnt_type[joint])
    if kind in (HINGE, SLIDE):
        off, speed = abs(float(data.qpos[at] - start[at])), abs(float(data.qvel[dof]))
        unit = "rad" if kind == HINGE else "m"
        yield off / (TURN if kind == HINGE else SLIP), joint, f"moved by {off:.2g} {unit}"
        yield speed / SPEED, joint, f"still moves at {speed:.2g} {unit}/s"
        return
    if kind == FREE:
        off = float(np.linalg.norm(data.qpos[at : at + 3] - start[at : at + 3]))
        yield off / SLIP, joint, f"moved by {off:.2g} m"
        at += 3
    turned = np.zeros(3)
    mujoco.mju_subQuat(turned, data.qpos[at : at + 4].copy(), start[at : at + 4].copy())
    angle = float(np.linalg.norm(turned))
    yield angle / TURN, joint, f"turned by {angle:.2g} rad"


def _finding(model: Any, joint: int, words: str) -> Finding:
    name = model.joint(joint).name
    own = [one for one in range(model.nu) if int(model.actuator_trnid[one][0]) == joint]
    if model.jnt_type[joint] == FREE:
        return Finding(
            named_joint(model, joint), "", f"the base {words}: it does not stand at home by itself"
        )
    if own:
        actuator = model.actuator(own[0]).name
        return Finding(
            named("actuator", actuator), "ctrl of the keyframe home", f"{name} {words}: it does not hold it"
        )
    return Finding(named_joint(model, joint), "", f"it {words}, and nothing drives it")
