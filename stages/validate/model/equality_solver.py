"""Closes the equalities of a compiled model (relations and loops) after a joint has moved."""

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.model.coordinates import HINGE, SLIDE

_MAX_ITERATIONS = 6
"""Largest number of steps of Newton's method for a pose."""

EQUALITY_TOLERANCE = 1e-5
"""Tolerance of equalities [m, rad], which is exact enough for collisions."""

MIN_COLUMN_ENTRY = 1e-9
"""A dof does not move an equality if all entries of its column in the equalities' Jacobian are below this."""

_MIN_SINGULAR_VALUE_SHARE = 1e-9
"""Singular values of the Jacobian below this share of the largest are only rounding: equalities may be
redundant."""

_DISABLED_CONSTRAINTS = int(
    mujoco.mjtDisableBit.mjDSBL_CONTACT
    | mujoco.mjtDisableBit.mjDSBL_LIMIT
    | mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
)
"""Kinds of constraints that are not needed here, and are left out of the Jacobian."""

_JOINT_TRANSMISSIONS = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
"""The transmissions of actuators that drive a joint."""


@dataclass(slots=True)
class EqualitySolver:
    """Closes the equalities of a model by Newton's method, from a pose nearby."""

    model: Any
    _data: Any = field(init=False)

    def __post_init__(self) -> None:
        self._data = mujoco.MjData(self.model)

    def solve(self, joint: int, value: float, start: Array) -> Array | None:
        """Returns a pose (nq,) with a joint at `value` and closed equalities, found by small changes of the
        other joints from the pose `start`. Returns None if the equalities cannot be closed."""
        model, data = self.model, self._data
        pose = start.copy()
        pose[model.jnt_qposadr[joint]] = value
        if not model.neq:
            return pose
        dof = int(model.jnt_dofadr[joint])
        for _ in range(_MAX_ITERATIONS):
            jacobian, error = jacobian_and_errors(model, data, pose)
            if np.abs(error).max(initial=0.0) < EQUALITY_TOLERANCE:
                return pose
            # The joint stays at its value.
            jacobian[:, dof] = 0.0
            step = -np.linalg.lstsq(jacobian, error, rcond=_MIN_SINGULAR_VALUE_SHARE)[0]
            step[dof] = 0.0
            mujoco.mj_integratePos(model, pose, step, 1.0)
        _, error = jacobian_and_errors(model, data, pose)
        return pose if np.abs(error).max(initial=0.0) < EQUALITY_TOLERANCE else None


def jacobian_and_errors(model: Any, data: Any, pose: Array) -> tuple[Array, Array]:
    """Returns the Jacobian (E, nv) of the equalities at a pose, and their errors (E,)."""
    data.qpos[:] = pose
    flags, model.opt.disableflags = model.opt.disableflags, model.opt.disableflags | _DISABLED_CONSTRAINTS
    try:
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeConstraint(model, data)
    finally:
        model.opt.disableflags = flags
    rows = np.flatnonzero(data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    jacobian = np.zeros((data.nefc, model.nv))
    if mujoco.mj_isSparse(model):
        mujoco.mju_sparse2dense(jacobian, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
    else:
        jacobian[:] = data.efc_J.reshape(-1, model.nv)[: data.nefc]
    return jacobian[rows], np.array(data.efc_pos[rows])


def swept_joints(model: Any, pose: Array) -> list[int]:
    """Returns the hinges, and the slides that have limits. Of joints that equalities couple, only the driven
    joints are returned, or, if none is driven, those that follow no relation. A joint is driven by an
    actuator of its own. `pose` (nq,): where the coupling is tested."""
    scalar_joints = [
        joint
        for joint in range(model.njnt)
        if model.jnt_type[joint] == HINGE or (model.jnt_type[joint] == SLIDE and model.jnt_limited[joint])
    ]
    if not model.neq:
        return scalar_joints
    jacobian, _ = jacobian_and_errors(model, mujoco.MjData(model), pose)
    coupled_dofs = np.abs(jacobian).max(axis=0, initial=0.0) > MIN_COLUMN_ENTRY
    # The target of any other actuator is not a joint, but for example a tendon.
    drives_joint = np.isin(model.actuator_trntype, _JOINT_TRANSMISSIONS)
    driven_joints = {int(joint) for joint in model.actuator_trnid[drives_joint, 0]}
    relations = model.eq_type == mujoco.mjtEq.mjEQ_JOINT
    followers = {int(joint) for joint in model.eq_obj1id[relations]}
    coupled_joints = {joint for joint in scalar_joints if coupled_dofs[model.jnt_dofadr[joint]]}
    independent = (coupled_joints & driven_joints) or (coupled_joints - followers)
    return [joint for joint in scalar_joints if joint not in coupled_joints or joint in independent]
