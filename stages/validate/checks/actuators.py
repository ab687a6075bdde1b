"""Each actuator drives its dof with its gains and ranges, and `home` has its control and its state."""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from stages.robot.actuation import Actuator
from stages.robot.check import Check
from stages.robot.home_control import state_at, torque_per_volt
from stages.robot.model import Array, Value
from stages.robot.start_pose import home
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import SAME, joint_index

CODE = "C-ACTUATOR"


def check(compiled: CompiledModel) -> Iterator[Check]:
    """A URDF has no actuators."""
    if compiled.urdf:
        return
    model, expected = compiled.model, compiled.actuation.actuators
    number = len(expected) + compiled.surplus.actuators
    if not expected and model.nu == number:
        return
    rest = home(compiled.robot)
    wrong = [one.name for one in expected if not _fits(model, one, rest[one.dof])]
    detail = f"{len(expected)} actuators with their dofs, gains and ranges"
    if wrong:
        detail = f"differ: {', '.join(wrong)}"
    elif model.nu != number:
        detail = f"expected {number} actuators, found {model.nu}"
    yield compiled.result("actuators", not wrong and model.nu == number, detail, float(len(wrong)), 0.0)


def _fits(model: Any, one: Actuator, value: Value) -> bool:
    """`value`: of the dof at `home`."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, one.name)
    if index < 0:
        return False
    pairs = [(model.actuator_gear[index][0], one.gear), *_gains(model, index, one)]
    saturated = any(name == "saturation" for name, _ in one.terms)
    for ends, limited, numbers in (
        (one.control, model.actuator_ctrllimited[index], model.actuator_ctrlrange[index]),
        (one.force, model.actuator_forcelimited[index], model.actuator_forcerange[index]),
    ):
        if bool(limited) != (ends is not None) and not saturated:
            return False
        pairs += [] if ends is None else zip(numbers, ends, strict=True)
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "home")
    pairs.append((model.key_ctrl[key][index] if key >= 0 else np.nan, one.home))
    state = () if isinstance(value, tuple) else state_at(one, value)
    if int(model.actuator_actnum[index]) != len(state):
        return False
    first = int(model.actuator_actadr[index])
    pairs += zip(model.key_act[key][first : first + len(state)], state, strict=True) if state else []
    found, expected = (np.array(side, dtype=float) for side in zip(*pairs, strict=True))
    return int(model.actuator_trnid[index][0]) == joint_index(model, one.dof) and _same(found, expected)


def _gains(model: Any, index: int, one: Actuator) -> list[tuple[float, float]]:
    """(in the model, expected) of what the type of an actuator, with its kp and kv, makes of the force."""
    gain, bias = model.actuator_gainprm[index], model.actuator_biasprm[index]
    kp, kv = one.kp or 0.0, one.kv or 0.0
    servo = (kp, 0.0, -kp, -kv)
    known = {
        "position": servo,
        "intvelocity": servo,
        "velocity": (kv, 0.0, 0.0, -kv),
        "motor": (1.0, 0, 0, 0),
    }
    if one.type == "damper":
        return [(gain[2], -kv)]
    if one.type == "pid":
        return [(bias[1], -kp), (bias[2], -kv)]
    if one.type == "dcmotor":
        return [(gain[1] / gain[0], torque_per_volt(one))]
    found = (gain[0], *bias[:3])
    return list(zip(found, known.get(one.type, found), strict=True))


def _same(found: Array, expected: Array) -> bool:
    return bool((np.abs(found - expected) <= SAME * np.maximum(1.0, np.abs(expected))).all())
