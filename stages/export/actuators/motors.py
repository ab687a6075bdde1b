"""Applies the values of motors from the library to the dofs and actuators that name them.

A motor's values are at its output. With a `gear` between motor and dof, forces are multiplied by the ratio,
speeds are divided by it, and inertia and damping are multiplied by its square (equal power on both sides).

The more specific value wins. In falling order: a configuration entry with the dof's own name; a motor that
is assigned to the dof by name; a configuration glob; a motor that is assigned by a glob; the source.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.actuators.choices import WHERE, ChosenActuator
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.actuation import SERVOS, Supplied
from linkwright.stages.robot.model.robot import Dof
from linkwright.stages.robot.text.globs import as_key, listed

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.motor_section import MotorSection, MotorValue

Motors = Mapping[str, "MotorSection"]

GEAR_EXPONENTS = {"damping": 2, "friction": 1, "armature": 2, "effort": 1, "velocity": -1}
"""Quantity of a dof → the exponent of the gear ratio in the factor from the motor to the dof."""

RELATIVE_TOLERANCE = 1e-9
"""Relative tolerance within which two values count as equal."""


@dataclass(frozen=True, slots=True)
class OverriddenValue:
    """A motor's value that the configuration overrides."""

    dof: str

    words: str
    """The quantity, the motor's value, and the value that replaces it."""


@dataclass(frozen=True, slots=True)
class MotorizedParameters:
    """The parameters of an actuator, completed by its motor."""

    parameters: Mapping[str, Any]

    sources: tuple[tuple[str, str], ...] = ()
    """(parameter, origin of its value) for those that the motor sets."""

    overruled: tuple[OverriddenValue, ...] = ()
    """The motor's values that the configuration overrides."""


def motor_values(
    dofs: Sequence[Dof], choices: Mapping[str, ChosenActuator], motors: Motors, log: Diagnostics
) -> tuple[list[Supplied], list[OverriddenValue]]:
    """Returns the values that motors set on these dofs, and the motors' values that the key `joints`
    overrides. Reports the values of the source that motors replace (I-MOTOR)."""
    supplied_values, overruled, replaced = [], [], []
    for dof in dofs:
        choice = choices.get(dof.name)
        if choice is None or not choice.motor:
            continue
        gear = abs(float(choice.parameters.get("gear", 1.0)))
        for quantity, value, source in _output_values(motors[choice.motor], choice.type):
            value_at_dof = value * gear ** GEAR_EXPONENTS[quantity]
            previous = getattr(dof.dynamics, quantity)
            differs = previous is not None and not math.isclose(
                previous, value_at_dof, rel_tol=RELATIVE_TOLERANCE
            )
            if quantity in (dof.named if choice.motor_named else dof.given):
                if differs:
                    words = f"{quantity} of {dof.name} ({value_at_dof:.6g}; `joints` gives {previous:.6g})"
                    overruled.append(OverriddenValue(dof.name, words))
                continue
            if differs:
                replaced.append(f"{quantity} of {dof.name} ({previous:.6g} → {value_at_dof:.6g})")
            supplied_values.append(
                Supplied(dof.name, quantity, value_at_dof, f"motor {choice.motor}: {source}")
            )
    if replaced:
        text = f"motors override values of the source or of a glob of `joints`: {listed(replaced)}"
        log.report("I-MOTOR", text, WHERE, "values in `joints` under the joint's own name stay")
    return supplied_values, overruled


def report_overridden(
    overruled: Sequence[OverriddenValue], choices: Mapping[str, ChosenActuator], log: Diagnostics
) -> None:
    """Reports the motors' values that the configuration overrides (I-MOTOR)."""
    if not overruled:
        return
    text = f"the configuration overrides values of motors: {listed(loss.words for loss in overruled)}"
    by_glob = [loss.dof for loss in overruled if not choices[loss.dof].motor_named]
    hint = "leave the value out to have the motor's"
    if by_glob:
        motor = choices[by_glob[0]].motor
        hint += f", or name the motor for the joint: actuators: {{{as_key(by_glob[0])}: {{motor: {motor}}}}}"
    log.report("I-MOTOR", text, WHERE, hint)


def _output_values(motor: MotorSection, kind: str) -> Iterator[tuple[str, float, str]]:
    """Yields (quantity of a dof, value at the motor's output, source) for each quantity that a motor has.

    Back-EMF counts as damping, unless the actuator is a dcmotor, for which MuJoCo computes it.
    """
    values = motor.values
    for quantity in ("damping", "friction", "armature", "effort", "velocity"):
        parts = [quantity]
        if quantity == "damping" and kind != "dcmotor":
            parts.append("back_emf")
        if quantity == "armature" and quantity not in values:
            parts = ["rotor_inertia"]
        sources = [values[name] for name in parts if name in values]
        if not sources:
            continue
        total = sum(value.value for value in sources)
        if parts == ["rotor_inertia"]:
            # The rotor's inertia is given at the rotor: reflect it through the motor's own gearbox.
            total *= values["gear"].value ** 2
            sources.append(values["gear"])
        yield quantity, total, "; ".join(dict.fromkeys(map(_sourced, sources)))


def _sourced(value: MotorValue) -> str:
    return f"{value.source} ({value.kind})"


def kinds_of(source: str) -> list[str]:
    """Returns the kinds (measured, identified, datasheet) that a text of `sources` names."""
    return re.findall(r" \((measured|identified|datasheet)\)(?:; |\Z)", source)


def with_motor(dof: str, choice: ChosenActuator, motors: Motors) -> MotorizedParameters:
    """Returns the parameters of an actuator, completed by its motor. The motor's kv is used only with its
    kp, and `nominal` replaces the motor's constants."""
    if not choice.motor:
        return MotorizedParameters(choice.parameters)
    values = motors[choice.motor].values
    parameters = dict(choice.parameters)
    user_set = {name for name in parameters if not choice.motor_named or choice.origin.get(name) == dof}
    sources: dict[str, str] = {}
    overruled: list[OverriddenValue] = []

    def apply(quantity: str, parameter: str, rivals: tuple[str, ...], value: Any) -> None:
        """Sets a parameter to the motor's value, unless the user set it or one of its `rivals`."""
        rival = next((name for name in (parameter, *rivals) if name in user_set), None)
        if rival is None:
            # A rival from a glob gives way; one that the motor set itself stays.
            for name in set(rivals) - sources.keys():
                parameters.pop(name, None)
            parameters[parameter] = value
            sources[parameter] = f"motor {choice.motor}: {_sourced(values[quantity])}"
        elif parameters[rival] != value:
            words = f"{quantity} of {dof} ({values[quantity].value:.6g}; `actuators` gives {rival})"
            overruled.append(OverriddenValue(dof, words))

    for quantity, parameter, rivals, value in _motor_parameters(choice.type, values):
        if quantity in values:
            apply(quantity, parameter, rivals, value)
    return MotorizedParameters(parameters, tuple(sources.items()), tuple(overruled))


def _motor_parameters(
    kind: str, values: Mapping[str, MotorValue]
) -> Iterator[tuple[str, str, tuple[str, ...], Any]]:
    """Yields (quantity of the motor, parameter, other parameters that exclude it, value) for an actuator
    type."""
    value = {name: motor_value.value for name, motor_value in values.items()}
    if kind in SERVOS:
        yield "kp", "kp", (), value.get("kp")
        if "kp" in value:
            yield "kv", "kv", ("dampratio", "kp"), value.get("kv")
    elif kind == "dcmotor":
        yield "torque_constant", "motorconst", ("nominal",), (value.get("torque_constant"),)
        yield "resistance", "resistance", ("nominal",), value.get("resistance")
        volts = value.get("voltage", 0.0)
        yield "voltage", "ctrlrange", (), (-volts, volts)
