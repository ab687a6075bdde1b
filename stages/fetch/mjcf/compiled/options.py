"""Reads the options and flags of a compiled model that are not MuJoCo's defaults, in the words of an MJCF."""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.fields import bare
from linkwright.stages.robot.model.scene import Setting

_ENUMS = {
    "cone": mujoco.mjtCone,
    "integrator": mujoco.mjtIntegrator,
    "jacobian": mujoco.mjtJacobian,
    "solver": mujoco.mjtSolver,
}

_NAMES = {"disableactuator": "actuatorgroupdisable"}

ALWAYS = ("timestep", "integrator")
"""Options that are always written, since our defaults differ from MuJoCo's."""

_GROUP_COUNT = 31
"""Number of groups of actuators: bits of MuJoCo's integer."""


def options(model: Any) -> Iterator[tuple[str, Setting]]:
    """Yields (attribute of <option>, value)."""
    for field in dir(model.opt):
        if field.startswith("_") or field.endswith("flags") or callable(getattr(model.opt, field)):
            continue
        value, default = getattr(model.opt, field), getattr(bare().opt, field)
        if np.array_equal(value, default) and field not in ALWAYS:
            continue
        yield _NAMES.get(field, field), _setting(field, value)


def _setting(field: str, value: Any) -> Setting:
    if field in _ENUMS:
        word = str(_ENUMS[field](int(value)).name.split("_", 1)[1])
        return {"euler": "Euler", "newton": "Newton"}.get(word.lower(), _case(field, word))
    if field == "disableactuator":
        return tuple(float(group) for group in range(_GROUP_COUNT) if int(value) & 1 << group)
    if np.ndim(value):
        return tuple(map(float, value))
    return float(value)


def _case(field: str, word: str) -> str:
    """Returns the word in MuJoCo's case: the names of algorithms are in capitals, other words in small
    letters."""
    return word if field == "solver" or word == "RK4" else word.lower()


def flags(model: Any) -> Iterator[tuple[str, str]]:
    """Yields (attribute of <flag>, enable or disable)."""
    for field, kinds in (("disableflags", mujoco.mjtDisableBit), ("enableflags", mujoco.mjtEnableBit)):
        value, default_bits = int(getattr(model.opt, field)), int(getattr(bare().opt, field))
        for name, member in kinds.__members__.items():
            bit = int(member)
            if bit.bit_count() == 1 and not name.startswith("mjN") and (value ^ default_bits) & bit:
                is_enabled = bool(value & bit) == (field == "enableflags")
                yield name.split("_", 1)[1].lower(), "enable" if is_enabled else "disable"
