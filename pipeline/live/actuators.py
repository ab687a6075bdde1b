"""The actuators of the header, one entry for each number of `ctrl`."""

from collections.abc import Iterator
from typing import Any

import mujoco

from pipeline.live.compiled import LiveModel
from pipeline.live.rounding import vector

_OF_JOINTS = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
_RATE = {"rad": "rad/s", "m": "m/s"}
_FORCE = {"rad": "N m", "m": "N"}
_INPUTS = ("POS", "VEL", "FF", "VOLTAGE", "PRESSURE")
_WORDS = {"POS": "position", "VEL": "velocity", "FF": "force", "VOLTAGE": "voltage", "PRESSURE": "pressure"}


def actuators(live: LiveModel, joints: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The actuators in the order of `ctrl`; one with several inputs has an entry for each of them.

    `range` is null where ctrl is not limited; `joint` where it drives none, or several.
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
    if kind in ("position", "intvelocity") or wanted == "POS":
        return unit
    if kind == "velocity" or wanted == "VEL":
        return _RATE.get(unit, "")
    return _FORCE.get(unit, "") if kind == "motor" or wanted == "FF" else ""
