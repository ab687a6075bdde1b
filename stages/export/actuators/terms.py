"""Writes an actuator's MJCF attributes that have no field of their own in `Actuator`."""

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
) -> Iterator[tuple[str, str]]:
    """Yields (attribute, text) in a fixed order. `kind`: the type of the actuator; `parameters`: its values,
    before the gear; `gear` [-]; `timestep` [s]."""
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
    for name in names:
        if name in parameters:
            yield name, _text(parameters[name])
    if "delay" in parameters:
        yield from _delay_attributes(parameters, timestep)


def _delay_attributes(parameters: Mapping[str, Any], timestep: float) -> Iterator[tuple[str, str]]:
    """Yields the attributes of a delay, which MuJoCo stores as a number of steps."""
    yield "delay", _text(parameters["delay"])
    # The tolerance keeps a delay of a whole number of steps at that number, in spite of rounding errors.
    yield "nsample", str(max(1, math.ceil(parameters["delay"] / timestep - 1e-6)))
    if "interp" in parameters:
        yield "interp", parameters["interp"]


def _text(value: str | float | Sequence[float]) -> str:
    if isinstance(value, str):
        return value
    numbers = value if isinstance(value, Sequence) else (value,)
    return " ".join(f"{part:.12g}" for part in numbers)
