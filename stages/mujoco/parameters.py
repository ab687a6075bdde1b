"""Lists the parameters of a compiled model's joints and actuators, with their places in MuJoCo's arrays."""

from collections.abc import Iterator
from typing import Any

import mujoco

Entry = tuple[str, tuple[int, ...]]
"""(field, index): a number of the model."""

Parameters = Iterator[tuple[str, tuple[Entry, ...]]]
"""(name, entries) of each parameter; all its entries scale by one factor."""

_DOFS_BY_TYPE = {
    mujoco.mjtJoint.mjJNT_HINGE: 1,
    mujoco.mjtJoint.mjJNT_SLIDE: 1,
    mujoco.mjtJoint.mjJNT_BALL: 3,
}
"""Type of a joint → its number of degrees of freedom."""

_FIELDS_OF_DOFS = {"damping": "dof_damping", "friction": "dof_frictionloss", "armature": "dof_armature"}
"""Parameter → the field that holds it for each degree of freedom."""


def joint_parameters(model: Any, joint: int) -> Parameters:
    """Yields the parameters of a joint; nothing for a free joint."""
    dof_count = _DOFS_BY_TYPE.get(mujoco.mjtJoint(int(model.jnt_type[joint])))
    if dof_count is None:
        return
    first = int(model.jnt_dofadr[joint])
    for name, field in _FIELDS_OF_DOFS.items():
        yield name, tuple((field, (row,)) for row in range(first, first + dof_count))
    yield "stiffness", (("jnt_stiffness", (joint,)),)
    if model.jnt_actfrclimited[joint]:
        yield "effort", tuple(("jnt_actfrcrange", (joint, k)) for k in range(2))


def actuator_parameters(model: Any, actuator: int) -> Parameters:
    """Yields the gains of an actuator that have a name, and its limits."""
    yield from _gains(model, actuator)
    yield from _limits(model, actuator)


def _gains(model: Any, actuator: int) -> Parameters:
    """Yields (name, entries) of an actuator's gains. The factors of a servo's control and of its value or
    speed are a single stiffness or damping. Skips kinds whose parameters have other meanings."""
    gain, bias = model.actuator_gainprm[actuator].tolist(), model.actuator_biasprm[actuator].tolist()
    kind = mujoco.mjtGain(int(model.actuator_gaintype[actuator]))
    affine = int(model.actuator_biastype[actuator]) == mujoco.mjtBias.mjBIAS_AFFINE
    if not affine and int(model.actuator_biastype[actuator]) != mujoco.mjtBias.mjBIAS_NONE:
        return

    def entries(*places: tuple[str, int]) -> tuple[Entry, ...]:
        return tuple((f"actuator_{array}prm", (actuator, k)) for array, k in places)

    if kind == mujoco.mjtGain.mjGAIN_FIXED and affine and bias[0] == 0 and gain[0] != 0:
        if bias[1] == -gain[0]:
            yield "kp", entries(("gain", 0), ("bias", 1))
            yield "kv", entries(("bias", 2))
            return
        if bias[1] == 0 and bias[2] == -gain[0]:
            yield "kv", entries(("gain", 0), ("bias", 2))
            return
    if kind == mujoco.mjtGain.mjGAIN_AFFINE and not affine and gain[0] == gain[1] == 0:
        yield "kv", entries(("gain", 2))
    elif kind in (mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtGain.mjGAIN_AFFINE):
        yield "gain", entries(*(("gain", k) for k in range(3)), *(("bias", k) for k in range(3) if affine))


def _limits(model: Any, actuator: int) -> Parameters:
    if model.actuator_forcelimited[actuator]:
        yield "force", tuple(("actuator_forcerange", (actuator, k)) for k in range(2))
