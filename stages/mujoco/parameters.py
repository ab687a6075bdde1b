"""Lists the parameters of joints and actuators of a compiled model, with their places in MuJoCo's arrays."""

from collections.abc import Iterator
from typing import Any

import mujoco

Entry = tuple[str, tuple[int, ...]]
"""The place of a number in the model: (field of MjModel, index)."""

Parameters = Iterator[tuple[str, tuple[Entry, ...]]]
"""(name, entries) of each parameter. To scale a parameter, multiply all entries by the same factor."""

_DOF_COUNTS = {
    mujoco.mjtJoint.mjJNT_HINGE: 1,
    mujoco.mjtJoint.mjJNT_SLIDE: 1,
    mujoco.mjtJoint.mjJNT_BALL: 3,
}
"""Type of a joint → its number of degrees of freedom, for joints with parameters."""

_FIELDS_OF_DOFS = {"damping": "dof_damping", "friction": "dof_frictionloss", "armature": "dof_armature"}
"""Parameter → the field with its value for each degree of freedom."""


def joint_parameters(model: Any, joint: int) -> Parameters:
    """Yields the parameters of a joint; nothing for a free joint."""
    dof_count = _DOF_COUNTS.get(mujoco.mjtJoint(int(model.jnt_type[joint])))
    if dof_count is None:
        return
    first = int(model.jnt_dofadr[joint])
    for name, field in _FIELDS_OF_DOFS.items():
        yield name, tuple((field, (row,)) for row in range(first, first + dof_count))
    yield "stiffness", (("jnt_stiffness", (joint,)),)
    if model.jnt_actfrclimited[joint]:
        yield "effort", tuple(("jnt_actfrcrange", (joint, k)) for k in range(2))


def actuator_parameters(model: Any, actuator: int) -> Parameters:
    """Yields the gains of an actuator and its force limits."""
    yield from _gains(model, actuator)
    yield from _limits(model, actuator)


def _gains(model: Any, actuator: int) -> Parameters:
    """Yields the gains of an actuator; nothing for types whose numbers have other meanings, such as muscles.

    A servo multiplies its control and its value or speed by the same number: this is a single parameter, the
    stiffness `kp` or the damping `kv`.
    """
    gain, bias = model.actuator_gainprm[actuator].tolist(), model.actuator_biasprm[actuator].tolist()
    kind = mujoco.mjtGain(int(model.actuator_gaintype[actuator]))
    is_affine = int(model.actuator_biastype[actuator]) == mujoco.mjtBias.mjBIAS_AFFINE
    if not is_affine and int(model.actuator_biastype[actuator]) != mujoco.mjtBias.mjBIAS_NONE:
        return

    def entries(*places: tuple[str, int]) -> tuple[Entry, ...]:
        return tuple((f"actuator_{array}prm", (actuator, k)) for array, k in places)

    if kind == mujoco.mjtGain.mjGAIN_FIXED and is_affine and bias[0] == 0 and gain[0] != 0:
        if bias[1] == -gain[0]:
            yield "kp", entries(("gain", 0), ("bias", 1))
            yield "kv", entries(("bias", 2))
            return
        if bias[1] == 0 and bias[2] == -gain[0]:
            yield "kv", entries(("gain", 0), ("bias", 2))
            return
    if kind == mujoco.mjtGain.mjGAIN_AFFINE and not is_affine and gain[0] == gain[1] == 0:
        yield "kv", entries(("gain", 2))
    elif kind in (mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtGain.mjGAIN_AFFINE):
        yield "gain", entries(*(("gain", k) for k in range(3)), *(("bias", k) for k in range(3) if is_affine))


def _limits(model: Any, actuator: int) -> Parameters:
    """Yields the force limits of an actuator as a single parameter; nothing without limits."""
    if model.actuator_forcelimited[actuator]:
        yield "force", tuple(("actuator_forcerange", (actuator, k)) for k in range(2))
