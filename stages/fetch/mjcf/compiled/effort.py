"""The effort limit of each joint, from its own bound and those of its actuators."""

import math
from typing import Any

import mujoco
import numpy as np

_OF_JOINTS = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)


def efforts(model: Any) -> dict[int, float]:
    """By joint [N m or N], of hinges and slides that have a bound: the smaller of the joint's own
    (`actuatorfrcrange`) and the sum of its actuators' largest forces. Of an asymmetric range the larger
    side."""
    bounds: dict[int, float] = {}
    for actuator in range(len(model.actuator_trntype)):
        joint = int(model.actuator_trnid[actuator][0])
        if int(model.actuator_trntype[actuator]) in _OF_JOINTS:
            bounds[joint] = bounds.get(joint, 0.0) + _largest(model, actuator)
    for joint in range(model.njnt):
        if model.jnt_actfrclimited[joint]:
            own = float(np.abs(model.jnt_actfrcrange[joint]).max())
            bounds[joint] = min(bounds.get(joint, math.inf), own)
    scalar = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    return {
        joint: bound
        for joint, bound in bounds.items()
        if 0 < bound < math.inf and int(model.jnt_type[joint]) in scalar
    }


def _largest(model: Any, actuator: int) -> float:
    """The largest force of an actuator at its joint: force times gear; for a plain motor, gain times
    control."""
    force = math.inf
    if model.actuator_forcelimited[actuator]:
        force = float(np.abs(model.actuator_forcerange[actuator]).max())
    plain = (
        model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_FIXED
        and model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE
        and model.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_NONE
    )
    if plain and model.actuator_ctrllimited[actuator]:
        control = float(np.abs(model.actuator_ctrlrange[actuator]).max())
        force = min(force, abs(float(model.actuator_gainprm[actuator][0])) * control)
    return force * abs(float(model.actuator_gear[actuator][0])) if force < math.inf else math.inf
