"""The actuators of the header, one entry for each number of `ctrl`."""

from collections.abc import Iterator
from typing import Any

import mujoco

from linkwright.stages.show.live.compiled import LiveModel
from linkwright.stages.show.live.rounding import rounded, vector

_OF_JOINTS = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
_OF_ONE_VALUE = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
_TARGETS = (mujoco.mjtDyn.mjDYN_INTEGRATOR, mujoco.mjtDyn.mjDYN_FILTER, mujoco.mjtDyn.mjDYN_FILTEREXACT)
_RATE = {"rad": "rad/s", "m": "m/s"}
_FORCE = {"rad": "N m", "m": "N"}
_INPUTS = ("POS", "VEL", "FF", "VOLTAGE", "PRESSURE")
_WORDS = {"POS": "position", "VEL": "velocity", "FF": "force", "VOLTAGE": "voltage", "PRESSURE": "pressure"}


def actuators(live: LiveModel, joints: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The actuators in the order of `ctrl`; one with several inputs has an entry for each of them.

    `range` is null where ctrl is not limited; `joint` where it drives none, or several. `target` is that of a
    servo of a hinge or a slide, else null: it rests at a value of the joint where its ctrl (unless `ctrl` is
    false) and this place of `act` (null: none) are slope · value + offset.
    """
    return [entry for index in range(_count(live.model)) for entry in _entries(live, index, joints)]


def _count(model: Any) -> int:
    # MuJoCo before 3.14 knows only actuators with one input.
    return int(getattr(model, "nactuator", model.nu))


def _entries(live: LiveModel, index: int, joints: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    model = live.model
    kind = live.actuators[index] if index < len(live.actuators) else "general"
    name = live.name(mujoco.mjtObj.mjOBJ_ACTUATOR, index) or f"actuator {index}"
    of_joint = mujoco.mjtTrn(int(model.actuator_trntype[index])) in _OF_JOINTS
    joint = int(model.actuator_trnid[index, 0]) if of_joint else None
    unit = "" if joint is None else str(joints[joint]["unit"])
    inputs = _inputs(model, index)
    for place, (ctrl, wanted) in enumerate(inputs):
        limited = bool(model.actuator_ctrllimited[ctrl])
        yield {
            "name": name if len(inputs) == 1 else f"{name} {_WORDS.get(wanted, str(place))}",
            "kind": kind,
            "joint": joint,
            "range": vector(model.actuator_ctrlrange[ctrl]) if limited else None,
            "unit": _unit(kind, wanted, unit),
            "target": None if joint is None or place else _target(model, index, wanted),
        }


def _target(model: Any, index: int, wanted: str) -> dict[str, Any] | None:
    """Where a servo's target is kept, and how it follows the joint: at rest gain · target + b₀ + b₁ · length
    is 0."""
    joint = mujoco.mjtJoint(int(model.jnt_type[model.actuator_trnid[index, 0]]))
    b0, b1 = (float(one) for one in model.actuator_biasprm[index, :2])
    kind, dynamics = int(model.actuator_gaintype[index]), int(model.actuator_dyntype[index])
    # MuJoCo before 3.12 has no PID.
    is_pid = kind == getattr(mujoco.mjtGain, "mjGAIN_PID", None) and wanted == "POS"
    is_fixed = kind == mujoco.mjtGain.mjGAIN_FIXED and dynamics in (mujoco.mjtDyn.mjDYN_NONE, *_TARGETS)
    gain = -b1 if is_pid else float(model.actuator_gainprm[index, 0])
    affine = model.actuator_biastype[index] == mujoco.mjtBias.mjBIAS_AFFINE and b1 and gain
    if joint not in _OF_ONE_VALUE or not affine or not (is_pid or is_fixed):
        return None
    # That of a PID is a state where its speed is limited; the control of an integrator is the target's speed.
    is_state = dynamics in _TARGETS or (is_pid and model.actuator_dynprm[index, 1] > 0)
    return {
        "ctrl": dynamics != mujoco.mjtDyn.mjDYN_INTEGRATOR,
        "act": int(model.actuator_actadr[index]) if is_state else None,
        "slope": rounded(-b1 * float(model.actuator_gear[index, 0]) / gain),
        "offset": rounded(-b0 / gain),
    }


def _inputs(model: Any, index: int) -> list[tuple[int, str]]:
    """The places of an actuator's inputs in `ctrl`, and what each one is."""
    if not hasattr(model, "actuator_ctrladr"):
        return [(index, "")]
    first, count = int(model.actuator_ctrladr[index]), int(model.actuator_ctrlnum[index])
    spec = int(model.actuator_ctrlspec[index])
    words = [word for word in _INPUTS if spec & int(getattr(mujoco.mjtCtrlInput, f"mjINPUT_{word}", 0) or 0)]
    words += [""] * (count - len(words))
    return [(first + place, words[place]) for place in range(count)]


def _unit(kind: str, wanted: str, unit: str) -> str:
    """The unit of an input: that of the joint, of its rate, or of its force."""
    if wanted == "VOLTAGE":
        return "V"
    if kind == "position" or wanted == "POS":
        return unit
    if kind in ("velocity", "intvelocity") or wanted == "VEL":
        return _RATE.get(unit, "")
    return _FORCE.get(unit, "") if kind == "motor" or wanted == "FF" else ""
