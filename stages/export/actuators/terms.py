"""The attributes of MJCF that only single types of actuators have, as text."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from linkwright.stages.export.configuration.actuator_section import DC_MOTOR
from linkwright.stages.robot.model.robot import Dof

OPEN = 1e6
"""The open end of the range of a target: MuJoCo up to 3.10 demands a range."""

GENERAL = ("dyntype", "gaintype", "biastype", "dynprm", "gainprm", "biasprm")


def terms_of(
    kind: str, given: Mapping[str, Any], dof: Dof, gear: float, timestep: float
) -> tuple[tuple[str, str], ...]:
    """(attribute, text), in a fixed order. `timestep` [s]: a delayed control is remembered for so many."""
    return tuple(_each(kind, given, dof, gear, timestep))


def _each(
    kind: str, given: Mapping[str, Any], dof: Dof, gear: float, timestep: float
) -> Iterator[tuple[str, str]]:
    names: tuple[str, ...] = ()
    if kind == "intvelocity":
        ends = (min(max(end, -OPEN), OPEN) for end in dof.limits.interval)
        yield "actrange", _text(sorted(gear * end for end in ends))
    elif kind == "pid":
        # Without the input of a speed: the control has one number, as that of a position servo.
        yield "input", "pos"
        names = ("ki", "imax", "slewmax")
    elif kind == "dcmotor":
        names = DC_MOTOR
    elif kind == "general":
        names = GENERAL
    for name in (*names, "delay"):
        if name in given:
            yield name, _text(given[name])
    if "delay" in given:
        # A time that is a whole number of steps needs no more, whatever its rounding.
        yield "nsample", str(max(1, math.ceil(given["delay"] / timestep - 1e-6)))
        if "interp" in given:
            yield "interp", given["interp"]


def _text(value: str | float | Sequence[float]) -> str:
    if isinstance(value, str):
        return value
    numbers = value if isinstance(value, Sequence) else (value,)
    return " ".join(f"{one:.12g}" for one in numbers)
