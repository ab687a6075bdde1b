"""Computes the effort limit of each joint, from its own bound and the bounds of its actuators."""

import math
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import controls_of

_JOINT_TRANSMISSIONS = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)


def efforts(model: Any) -> dict[int, float]:
    """Returns the effort [N m or N] of each hinge and slide that has a bound.

    The effort is the smaller of the joint's own bound (`actuatorfrcrange`) and the sum of its actuators'
    largest forces. An asymmetric range counts by its larger side.
    """
    bounds: dict[int, float] = {}
    for actuator in range(len(model.actuator_trntype)):
        joint = int(model.actuator_trnid[actuator][0])
        if int(model.actuator_trntype[actuator]) in _JOINT_TRANSMISSIONS:
            bounds[joint] = bounds.get(joint, 0.0) + _max_force(model, actuator)
    for joint in range(model.njnt):
        if model.jnt_actfrclimited[joint]:
            bound = float(np.abs(model.jnt_actfrcrange[joint]).max())
            bounds[joint] = min(bounds.get(joint, math.inf), bound)
    scalar_types = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    return {
        joint: bound
        for joint, bound in bounds.items()
        if 0 < bound < math.inf and int(model.jnt_type[joint]) in scalar_types
    }


def _max_force(model: Any, actuator: int) -> float:
    """Returns the largest force of an actuator at its joint: force times gear; for a plain motor, gain times
    control times gear."""
    force = math.inf
    if model.actuator_forcelimited[actuator]:
        force = float(np.abs(model.actuator_forcerange[actuator]).max())
    is_motor = (
        model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_FIXED
        and model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE
        and model.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_NONE
    )
    control = controls_of(model, actuator).start
    if is_motor and model.actuator_ctrllimited[control]:
        max_control = float(np.abs(model.actuator_ctrlrange[control]).max())
        force = min(force, abs(float(model.actuator_gainprm[actuator][0])) * max_control)
    gear = abs(float(model.actuator_gear[actuator][0]))
    return force * gear if gear else 0.0
