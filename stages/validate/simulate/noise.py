"""Noise over the whole range of each control."""

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.trial import EFFORT, failure
from linkwright.stages.mujoco.warnings import listening
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.model.coordinates import HINGE

HOLD = 0.1
"""In the second half of a run each control keeps a value for so long [s]: what is moved by it gets further
than by noise that is another at every step."""

OPEN = 1e6
"""The end of a range from here on stands for no limit [rad, m]."""

_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29)


def control_ranges(model: Any) -> Array:
    """The lowest and the highest control (nu, 2) of each actuator: its range; without one that of what it
    moves, where it is a servo, else ±1."""
    found = np.tile([-1.0, 1.0], (model.nu, 1))
    for actuator in range(model.nu):
        if model.actuator_ctrllimited[actuator]:
            found[actuator] = model.actuator_ctrlrange[actuator]
            continue
        joint = int(model.actuator_trnid[actuator][0])
        of_joint = model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT
        servo = model.actuator_biasprm[actuator][1] != 0.0
        if of_joint and servo and model.jnt_limited[joint]:
            found[actuator] = sorted(_ends(model, joint) * model.actuator_gear[actuator][0])
    return found


@dataclass(frozen=True, slots=True)
class Shake:
    """How a run with noise ended. `failed`: what went wrong, "" for nothing; `time` [s] when, or the end;
    `joint`: at which joint, "" where MuJoCo names none."""

    failed: str
    time: float
    joint: str = ""


def shaken(model: Any, seconds: float) -> Shake:
    """Runs a model from `home` with noise for controls. In the first half the noise is another at every step,
    in the second it is held for `HOLD`."""
    data = at_keyframe(model)
    low, high = control_ranges(model).T
    step = float(model.opt.timestep)
    steps = max(2, min(round(seconds / step), int(EFFORT / max(1, model.nv) ** 2)))
    held, done, turn = max(1, round(HOLD / step)), 0, 0
    with listening():
        while done < steps:
            turn += 1
            data.ctrl[:] = low + (high - low) * _halton(turn, model.nu)
            each = 1 if done < steps // 2 else min(held, steps - done)
            mujoco.mj_step(model, data, each)
            done += each
            if found := failure(model, data):
                return Shake(found[0], done * step, *found[1][:1])
    return Shake("", done * step)


def _ends(model: Any, joint: int) -> Array:
    """The ends (2,) of a joint's range; an end that is open is a turn, or a metre, from the other."""
    low, high = model.jnt_range[joint]
    span = 2.0 * np.pi if model.jnt_type[joint] == HINGE else 1.0
    if low <= -OPEN:
        low = high - span if high < OPEN else -span / 2
    return np.array([low, low + span if high >= OPEN else high])


def _halton(turn: int, count: int) -> Array:
    """Point number `turn` (count,) of a sequence that fills 0 to 1 evenly: Halton's in the first dimensions;
    his of high dimensions are all alike, so there each has one of the first turned by an irrational share."""
    found = np.empty(count)
    for at in range(count):
        lap, which = divmod(at, len(_PRIMES))
        found[at] = (mujoco.mju_Halton(turn, _PRIMES[which]) + lap * 0.618033988749895) % 1.0
    return found
