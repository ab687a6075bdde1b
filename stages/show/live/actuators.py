"""Describes the actuators for the header, with an entry for each number of `ctrl`."""

from collections.abc import Iterator
from typing import Any

import mujoco

from linkwright.stages.mujoco.names import actuator_count, controls_of
from linkwright.stages.show.live.compiled import LiveModel
from linkwright.stages.show.live.rounding import rounded, rounded_list

_JOINT_TRANSMISSIONS = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
_SCALAR_JOINTS = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
_STATEFUL_DYNAMICS = (
    mujoco.mjtDyn.mjDYN_INTEGRATOR,
    mujoco.mjtDyn.mjDYN_FILTER,
    mujoco.mjtDyn.mjDYN_FILTEREXACT,
)
_SPEED_UNITS = {"rad": "rad/s", "m": "m/s"}
_FORCE_UNITS = {"rad": "N m", "m": "N"}
_INPUT_KINDS = ("POS", "VEL", "FF", "VOLTAGE", "PRESSURE")
_INPUT_WORDS = {
    "POS": "position",
    "VEL": "velocity",
    "FF": "force",
    "VOLTAGE": "voltage",
    "PRESSURE": "pressure",
}


def actuators(live: LiveModel, joints: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Returns the actuators in the order of `ctrl`; an actuator with several inputs has several entries.

    `range` is null if ctrl is unlimited; `joint` is null if the actuator drives no joint, or several.
    `target` describes a servo of a hinge or a slide, and is null for other actuators: the servo holds the
    joint at a value if its ctrl (unless `target.ctrl` is false) and the entry `target.act` of `act` (unless
    null) are slope · value + offset.
    """
    return [entry for index in range(actuator_count(live.model)) for entry in _entries(live, index, joints)]


def _entries(live: LiveModel, index: int, joints: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    model = live.model
    kind = live.actuators[index] if index < len(live.actuators) else "general"
    name = live.name(mujoco.mjtObj.mjOBJ_ACTUATOR, index) or f"actuator {index}"
    drives_joint = mujoco.mjtTrn(int(model.actuator_trntype[index])) in _JOINT_TRANSMISSIONS
    joint = int(model.actuator_trnid[index, 0]) if drives_joint else None
    unit = "" if joint is None else str(joints[joint]["unit"])
    inputs = _inputs(model, index)
    for input_index, (ctrl, word) in enumerate(inputs):
        limited = bool(model.actuator_ctrllimited[ctrl])
        yield {
            "name": name if len(inputs) == 1 else f"{name} {_INPUT_WORDS.get(word, str(input_index))}",
            "kind": kind,
            "joint": joint,
            "range": rounded_list(model.actuator_ctrlrange[ctrl]) if limited else None,
            "unit": _unit(kind, word, unit),
            "target": None if joint is None or input_index else _target(model, index, word),
        }


def _target(model: Any, index: int, word: str) -> dict[str, Any] | None:
    """Returns where a servo's target is stored, and how the joint's value gives it (see `actuators`); None
    for other actuators. At rest the force gain · target + b₀ + b₁ · length is 0, with length = gear · joint
    value."""
    joint = mujoco.mjtJoint(int(model.jnt_type[model.actuator_trnid[index, 0]]))
    b0, b1 = (float(number) for number in model.actuator_biasprm[index, :2])
    kind, dynamics = int(model.actuator_gaintype[index]), int(model.actuator_dyntype[index])
    # MuJoCo before 3.12 has no PID.
    is_pid = kind == getattr(mujoco.mjtGain, "mjGAIN_PID", None) and word == "POS"
    is_fixed = kind == mujoco.mjtGain.mjGAIN_FIXED and dynamics in (
        mujoco.mjtDyn.mjDYN_NONE,
        *_STATEFUL_DYNAMICS,
    )
    gain = -b1 if is_pid else float(model.actuator_gainprm[index, 0])
    is_affine = model.actuator_biastype[index] == mujoco.mjtBias.mjBIAS_AFFINE and b1 and gain
    if joint not in _SCALAR_JOINTS or not is_affine or not (is_pid or is_fixed):
        return None
    # A PID's target is a state if its speed is limited; the control of an integrator is the target's speed.
    is_state = dynamics in _STATEFUL_DYNAMICS or (is_pid and model.actuator_dynprm[index, 1] > 0)
    return {
        "ctrl": dynamics != mujoco.mjtDyn.mjDYN_INTEGRATOR,
        "act": int(model.actuator_actadr[index]) if is_state else None,
        "slope": rounded(-b1 * float(model.actuator_gear[index, 0]) / gain),
        "offset": rounded(-b0 / gain),
    }


def _inputs(model: Any, index: int) -> list[tuple[int, str]]:
    """Returns the index in `ctrl` and the kind of each of an actuator's inputs."""
    controls = controls_of(model, index)
    # Before MuJoCo 4.0 each actuator has one input, of no stated kind.
    kinds = getattr(mujoco, "mjtCtrlInput", None)
    input_bits = 0 if kinds is None else int(model.actuator_ctrlspec[index])
    words = [word for word in _INPUT_KINDS if input_bits & int(getattr(kinds, f"mjINPUT_{word}", 0) or 0)]
    words += [""] * (len(controls) - len(words))
    return list(zip(controls, words, strict=False))


def _unit(kind: str, word: str, unit: str) -> str:
    """Returns the unit of an input: a unit of the joint's position, speed or force, or V."""
    if word == "VOLTAGE":
        return "V"
    if kind == "position" or word == "POS":
        return unit
    if kind in ("velocity", "intvelocity") or word == "VEL":
        return _SPEED_UNITS.get(unit, "")
    return _FORCE_UNITS.get(unit, "") if kind == "motor" or word == "FF" else ""
