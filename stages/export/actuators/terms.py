"""Writes the MJCF attributes that only some actuator types have."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from linkwright.stages.export.configuration.actuator_section import DC_MOTOR
from linkwright.stages.robot.model.robot import Dof

UNBOUNDED_END = 1e6
"""Substitute for an infinite end of the range of a target: MuJoCo up to 3.10 requires a finite range."""

GENERAL_PARAMETERS = ("dyntype", "gaintype", "biastype", "dynprm", "gainprm", "biasprm")
"""Parameters of the type general, with MuJoCo's names, in the order in which they are written."""


def terms_of(
    kind: str, parameters: Mapping[str, Any], dof: Dof, gear: float, timestep: float
) -> tuple[tuple[str, str], ...]:
    """Returns (attribute, text) in a fixed order, for an actuator of the type `kind` before the gear.
    `timestep` [s]: MuJoCo stores a delay as a number of steps."""
    return tuple(_attributes(kind, parameters, dof, gear, timestep))


def _attributes(
    kind: str, parameters: Mapping[str, Any], dof: Dof, gear: float, timestep: float
) -> Iterator[tuple[str, str]]:
    names: tuple[str, ...] = ()
    if kind == "intvelocity":
        ends = (min(max(end, -UNBOUNDED_END), UNBOUNDED_END) for end in dof.limits.interval)
        yield "actrange", _text(sorted(gear * end for end in ends))
    elif kind == "pid":
        # Without the input of a speed: the control has one number, as that of a position servo.
        yield "input", "pos"
        names = ("ki", "imax", "slewmax")
    elif kind == "dcmotor":
        names = DC_MOTOR
    elif kind == "general":
        names = GENERAL_PARAMETERS
    for name in (*names, "delay"):
        if name in parameters:
            yield name, _text(parameters[name])
    if "delay" in parameters:
        # The tolerance keeps a delay of a whole number of steps at that number, in spite of rounding errors.
        yield "nsample", str(max(1, math.ceil(parameters["delay"] / timestep - 1e-6)))
        if "interp" in parameters:
            yield "interp", parameters["interp"]


def _text(value: str | float | Sequence[float]) -> str:
    if isinstance(value, str):
        return value
    numbers = value if isinstance(value, Sequence) else (value,)
    return " ".join(f"{part:.12g}" for part in numbers)
