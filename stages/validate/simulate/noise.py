"""Runs a model with noise over the whole range of each control."""

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import actuator_count, controls_of
from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.trial import MAX_WORK, failure
from linkwright.stages.mujoco.warnings import collected_warnings
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.model.coordinates import HINGE

HOLD_TIME = 0.1
"""Time [s] for which each control keeps a value in the second half of a run, so that joints move further than
with noise that changes at every step."""

UNLIMITED = 1e6
"""Value [rad, m] from which the end of a range counts as no limit."""

_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29)
"""Bases of Halton's sequence: high bases give nearly equal dimensions."""

_GOLDEN_SHARE = 0.618033988749895
"""The golden ratio less 1: its multiples, taken modulo 1, are spread evenly."""


def control_ranges(model: Any) -> Array:
    """Returns the lowest and the highest value (nu, 2) of each control: its range; without a range, for the
    first control of a servo the range of its joint, else ±1."""
    limited = np.array(model.actuator_ctrllimited, bool)[:, None]
    ranges = np.where(limited, model.actuator_ctrlrange, [-1.0, 1.0])
    for actuator in range(actuator_count(model)):
        controls = controls_of(model, actuator)
        if not controls or limited[controls.start]:
            continue
        joint = int(model.actuator_trnid[actuator][0])
        is_on_joint = model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT
        # The force of a servo depends on its own position.
        is_servo = model.actuator_biasprm[actuator][1] != 0.0
        if is_on_joint and is_servo and model.jnt_limited[joint]:
            ranges[controls.start] = sorted(_ends(model, joint) * model.actuator_gear[actuator][0])
    return ranges


@dataclass(frozen=True, slots=True)
class Shake:
    """The end of a run with noise."""

    failure: str
    """The failure as text; "" without failure."""

    time: float
    """The time [s] of the failure, or of the end."""

    joint: str = ""
    """The joint at which the failure began; "" if MuJoCo names no joint."""


def run_with_noise(model: Any, seconds: float) -> Shake:
    """Runs a model from `home` with noise for controls. In the first half of the run the noise changes at
    every step, in the second half it is held for `HOLD_TIME`."""
    data = at_keyframe(model)
    low, high = control_ranges(model).T
    step = float(model.opt.timestep)
    # At least a step for each half.
    steps = max(2, min(round(seconds / step), int(MAX_WORK / max(1, model.nv) ** 2)))
    hold_steps, steps_done, draw = max(1, round(HOLD_TIME / step)), 0, 0
    with collected_warnings():
        while steps_done < steps:
            draw += 1
            data.ctrl[:] = low + (high - low) * _halton(draw, model.nu)
            count = 1 if steps_done < steps // 2 else min(hold_steps, steps - steps_done)
            mujoco.mj_step(model, data, count)
            steps_done += count
            if words_and_joints := failure(model, data):
                words, joints = words_and_joints
                return Shake(words, steps_done * step, joints[0] if joints else "")
    return Shake("", steps_done * step)


def _ends(model: Any, joint: int) -> Array:
    """Returns the ends (2,) of a joint's range. An open end is a turn, or a metre, from the other end."""
    low, high = model.jnt_range[joint]
    span = 2.0 * np.pi if model.jnt_type[joint] == HINGE else 1.0
    if low <= -UNLIMITED:
        low = high - span if high < UNLIMITED else -span / 2
    return np.array([low, low + span if high >= UNLIMITED else high])


def _halton(draw: int, dimensions: int) -> Array:
    """Returns point number `draw` (dimensions,) of a sequence that fills 0 to 1 evenly.

    The first dimensions are Halton's. Since Halton's high dimensions are nearly equal, further dimensions are
    copies of the first ones, shifted by multiples of an irrational number.
    """
    point = np.empty(dimensions)
    for dimension in range(dimensions):
        shift_count, prime_index = divmod(dimension, len(_PRIMES))
        halton = mujoco.mju_Halton(draw, _PRIMES[prime_index])
        point[dimension] = (halton + shift_count * _GOLDEN_SHARE) % 1.0
    return point
