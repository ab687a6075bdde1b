"""The joints of a compiled model that follow another's motion, by relations and closed loops."""

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.model.coordinates import HINGE, SLIDE

ITERATIONS = 6
CLOSED = 1e-5
"""Equalities are to hold within this [m, rad]: collisions need no more."""

COUPLED = 1e-9
"""A column of the equalities' Jacobian below this is none."""


@dataclass(slots=True)
class Follower:
    """Closes the equalities of a model by Newton's method, from a pose nearby. `start`: a pose where they
    hold (nq,)."""

    model: Any
    start: Array
    _data: Any = field(init=False)
    _closes: bool = field(init=False)

    def __post_init__(self) -> None:
        self._data = mujoco.MjData(self.model)
        self._closes = bool(self.model.neq)

    def at(self, joint: int, value: float, near: Array) -> Array | None:
        """The pose (nq,) with a joint at `value`, the others as near to `near` as the equalities let them;
        None where these cannot hold."""
        model, data = self.model, self._data
        pose = near.copy()
        pose[model.jnt_qposadr[joint]] = value
        if not self._closes:
            return pose
        dof = int(model.jnt_dofadr[joint])
        for _ in range(ITERATIONS):
            jacobian, error = equalities(model, data, pose)
            if np.abs(error).max(initial=0.0) < CLOSED:
                return pose
            jacobian[:, dof] = 0.0
            step = -np.linalg.lstsq(jacobian, error, rcond=1e-9)[0]
            step[dof] = 0.0
            mujoco.mj_integratePos(model, pose, step, 1.0)
        return pose if np.abs(equalities(model, data, pose)[1]).max(initial=0.0) < CLOSED else None


def equalities(model: Any, data: Any, pose: Array) -> tuple[Array, Array]:
    """The Jacobian (E, nv) of the equalities at a pose, and by how much they do not hold (E,)."""
    data.qpos[:] = pose
    flags, model.opt.disableflags = model.opt.disableflags, model.opt.disableflags | _OTHERS
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


_OTHERS = int(
    mujoco.mjtDisableBit.mjDSBL_CONTACT
    | mujoco.mjtDisableBit.mjDSBL_LIMIT
    | mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
)


def swept_joints(model: Any, pose: Array) -> list[int]:
    """The hinges and slides with a range, or that turn without one; of those that move each other the driven
    ones, or all but the followers of relations where nothing drives any."""
    scalar = [
        joint
        for joint in range(model.njnt)
        if model.jnt_type[joint] == HINGE or (model.jnt_type[joint] == SLIDE and model.jnt_limited[joint])
    ]
    if not model.neq:
        return scalar
    jacobian = equalities(model, mujoco.MjData(model), pose)[0]
    coupled = np.abs(jacobian).max(axis=0, initial=0.0) > COUPLED
    driven = {int(one) for one in model.actuator_trnid[:, 0]} if model.nu else set()
    relations = model.eq_type == mujoco.mjtEq.mjEQ_JOINT
    followers = {int(one) for one in model.eq_obj1id[relations]}
    bound = {joint for joint in scalar if coupled[model.jnt_dofadr[joint]]}
    kept = bound & driven or bound - followers
    return [joint for joint in scalar if joint not in bound or joint in kept]
