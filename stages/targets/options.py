"""Replaces options and actuators that targets do not accept by others that move the robot in the same way."""

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

from linkwright.stages.robot.dynamics.holding_control import torque_per_volt, volts_per_speed
from linkwright.stages.robot.model.actuation import Actuation, Actuator
from linkwright.stages.targets.engines import ENGINES
from linkwright.stages.targets.readers import READERS
from linkwright.stages.targets.row import Thing

PASSIVE_FLAGS: Mapping[str, Thing] = {"energy": "flag energy", "fwdinv": "flag fwdinv"}
"""Flag that only computes more, and moves nothing → the thing in the table of readers."""

REPLACEABLE_ACTUATORS: Mapping[str, Thing] = {"pid": "pid servos", "dcmotor": "motors by voltage"}
"""Type of actuator that can be written as another → the thing in the table of readers."""

_STATELESS_PARAMETERS = {"motorconst", "resistance", "nominal"}
"""Parameters of a motor by voltage that give it neither a state nor a limit."""


def targets_replacing(targets: Collection[str], thing: Thing) -> list[str]:
    """Returns the targets for which this thing is replaced."""
    return [
        name
        for name in targets
        if any(
            row.reader in ENGINES[name].readers and row.thing == thing and row.response == "replaced"
            for row in READERS
        )
    ]


def options_of(targets: Collection[str], options: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the attributes of `<option>` that the targets accept."""
    replaces_pgs = options.get("solver") == "PGS" and bool(targets_replacing(targets, "solver PGS"))
    return {**options, "solver": "Newton"} if replaces_pgs else dict(options)


def flags_of(targets: Collection[str], flags: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the attributes of `<flag>` that the targets accept."""
    omitted = [name for name, thing in PASSIVE_FLAGS.items() if targets_replacing(targets, thing)]
    # A target that refuses a flag accepts it disabled.
    return {name: value for name, value in flags.items() if name not in omitted or value == "disable"}


def actuation_of(targets: Collection[str], actuation: Actuation) -> Actuation:
    """Returns the actuators that the targets accept: each has the same force for the same control."""
    return replace(
        actuation, actuators=tuple(_replacement(targets, actuator) for actuator in actuation.actuators)
    )


def _replacement(targets: Collection[str], actuator: Actuator) -> Actuator:
    """Returns the actuator, or if a target does not accept it, another with the same force for the same
    control. There is none for a pid with `ki` or `slewmax`, and for a motor with a state or a limit."""
    thing = REPLACEABLE_ACTUATORS.get(actuator.type)
    if thing is None or not targets_replacing(targets, thing):
        return actuator
    terms = dict(actuator.terms)
    if actuator.type == "pid" and not {"ki", "slewmax"} & set(terms):
        return replace(actuator, type="position", terms=_without(terms, "input", "imax"))
    if actuator.type == "dcmotor" and set(terms) <= _STATELESS_PARAMETERS:
        gain = torque_per_volt(actuator)
        # With all digits, since the force must be the same.
        affine = {
            "gainprm": f"{gain:.17g}",
            "biastype": "affine",
            "biasprm": f"0 0 {-gain * volts_per_speed(actuator):.17g}",
        }
        return replace(actuator, type="general", terms=tuple(affine.items()))
    return actuator


def _without(terms: Mapping[str, str], *names: str) -> tuple[tuple[str, str], ...]:
    return tuple((name, text) for name, text in terms.items() if name not in names)
