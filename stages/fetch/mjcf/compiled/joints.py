"""Reads the joints of a body of a compiled model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.mjcf.model import MjcfJoint, MjcfJointType
from linkwright.stages.formats.numbers import exact
from linkwright.stages.mujoco.fields import joint_attributes
from linkwright.stages.robot.model.mjcf_extras import Attributes
from linkwright.stages.robot.model.robot import Dynamics, Limits, Spring, frozen

JOINTS: Mapping[int, MjcfJointType] = {
    int(mujoco.mjtJoint.mjJNT_HINGE): "hinge",
    int(mujoco.mjtJoint.mjJNT_SLIDE): "slide",
    int(mujoco.mjtJoint.mjJNT_BALL): "ball",
    int(mujoco.mjtJoint.mjJNT_FREE): "free",
}

_OPEN_BOUND = 1e6
"""Bound [rad or m] beyond which a side of a range counts as open: MuJoCo has no one-sided range."""

_DYNAMICS_ATTRIBUTES = ("damping", "frictionloss", "armature", "stiffness")
"""Attributes that `Dynamics` or `Spring` represents, unless they have several numbers."""


def joints_of(model: Any, body: int, efforts: Mapping[int, float]) -> tuple[MjcfJoint, ...]:
    """Returns the joints of a body, in order. `efforts`: effort limits by joint."""
    first = int(model.body_jntadr[body])
    return tuple(
        _joint(model, joint, efforts.get(joint))
        for joint in range(first, first + int(model.body_jntnum[body]))
    )


def _joint(model: Any, joint: int, effort: float | None) -> MjcfJoint:
    kind = JOINTS[int(model.jnt_type[joint])]
    is_scalar = kind in ("hinge", "slide")
    dof, qpos_index = int(model.jnt_dofadr[joint]), int(model.jnt_qposadr[joint])
    low, high = (float(bound) for bound in model.jnt_range[joint])
    has_range = is_scalar and model.jnt_limited[joint]

    def unless_zero(value: Any) -> float | None:
        return float(value) if kind != "free" and value else None

    return MjcfJoint(
        name=model.joint(joint).name,
        type=kind,
        anchor=frozen(np.zeros(3) if kind == "free" else model.jnt_pos[joint]),
        axis=frozen(model.jnt_axis[joint] if is_scalar else np.zeros(3)),
        ref=float(model.qpos0[qpos_index]) if is_scalar else 0.0,
        limits=Limits(
            low if has_range and low > -_OPEN_BOUND else None,
            high if has_range and high < _OPEN_BOUND else None,
        ),
        dynamics=Dynamics(
            damping=unless_zero(model.dof_damping[dof]),
            friction=unless_zero(model.dof_frictionloss[dof]),
            armature=unless_zero(model.dof_armature[dof]),
            effort=effort,
        ),
        spring=_spring(model, joint, qpos_index) if is_scalar or kind == "ball" else None,
        attributes=_attributes(model, joint, kind, effort),
    )


def _spring(model: Any, joint: int, qpos_index: int) -> Spring | None:
    """Returns the spring of a hinge, slide or ball whose first number in `qpos` is at `qpos_index`."""
    stiffness = float(model.jnt_stiffness[joint])
    reference = 0.0 if JOINTS[int(model.jnt_type[joint])] == "ball" else float(model.qpos_spring[qpos_index])
    return (
        Spring(stiffness, reference)
        if stiffness or "stiffness" in dict(joint_attributes(model, joint))
        else None
    )


def _attributes(model: Any, joint: int, kind: MjcfJointType, effort: float | None) -> Attributes:
    """Returns the attributes of a joint in the file besides its type, pose, limits and dynamics; for a free
    joint, all attributes. An effort that results from the actuators alone is not a limit of the joint."""
    values = dict(joint_attributes(model, joint))
    for name in _DYNAMICS_ATTRIBUTES:
        if kind != "free" and " " not in values.get(name, ""):
            values.pop(name, None)
    force_range = [float(bound) for bound in model.jnt_actfrcrange[joint]]
    if effort is not None and model.jnt_actfrclimited[joint] and -force_range[0] == force_range[1] == effort:
        values.pop("actuatorfrcrange", None)
    elif effort is not None and not model.jnt_actfrclimited[joint]:
        values["actuatorfrclimited"] = "false"
    if kind == "ball" and model.jnt_limited[joint]:
        values["range"] = exact(float(bound) for bound in model.jnt_range[joint])
    return tuple(values.items())
