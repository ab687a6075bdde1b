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
from typing import TYPE_CHECKING, Any, NamedTuple

from linkwright.stages.export.actuators.choices import WHERE, ChosenActuator
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.actuation import SERVOS, Supplied
from linkwright.stages.robot.model.robot import Dof
from linkwright.stages.robot.text.globs import name_list, yaml_key

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.motor_section import MotorSection, MotorValue

Motors = Mapping[str, "MotorSection"]
"""Name of a motor → its section in the library."""

GEAR_EXPONENTS = {"damping": 2, "friction": 1, "armature": 2, "effort": 1, "velocity": -1}
"""Quantity of a dof → the exponent of the gear ratio in the factor from the motor to the dof."""

RELATIVE_TOLERANCE = 1e-9
"""Relative tolerance within which two values count as equal."""


@dataclass(frozen=True, slots=True)
class OverriddenValue:
    """A motor's value that the configuration overrides."""

    dof: str

    text: str
    """The quantity, the motor's value, and the value that replaces it."""


@dataclass(frozen=True, slots=True)
class ParametersWithMotor:
    """The parameters of an actuator, completed by its motor."""

    parameters: Mapping[str, Any]

    origins: tuple[tuple[str, str], ...] = ()
    """(parameter, origin of its value) for each parameter that the motor sets."""

    overridden: tuple[OverriddenValue, ...] = ()
    """The motor's values that the configuration overrides."""


def motor_values(
    dofs: Sequence[Dof], choices: Mapping[str, ChosenActuator], motors: Motors, log: Diagnostics
) -> tuple[list[Supplied], list[OverriddenValue]]:
    """Returns the values that motors set on these dofs, and the motors' values that the key `joints`
    overrides. Reports the values of the source that motors replace (I-MOTOR)."""
    supplied_values, overridden, replaced = [], [], []
    for dof in dofs:
        choice = choices.get(dof.name)
        if choice is None or not choice.motor:
            continue
        for candidate in _values_at_dof(dof, choice, motors[choice.motor]):
            title, previous = f"{candidate.quantity} of {dof.name}", candidate.previous
            if not candidate.is_overridden:
                source = f"motor {choice.motor}: {candidate.source}"
                supplied_values.append(Supplied(dof.name, candidate.quantity, candidate.value, source))
                if candidate.differs:
                    replaced.append(f"{title} ({previous:.6g} → {candidate.value:.6g})")
            elif candidate.differs:
                text = f"{title} ({candidate.value:.6g}; `joints` gives {previous:.6g})"
                overridden.append(OverriddenValue(dof.name, text))
    if replaced:
        text = f"motors override values of the source or of a glob of `joints`: {name_list(replaced)}"
        log.report("I-MOTOR", text, WHERE, "to keep a value, give it in `joints` under the joint's own name")
    return supplied_values, overridden


class _ValueAtDof(NamedTuple):
    """A motor's value for a quantity of a dof."""

    quantity: str
    value: float
    """The value at the dof, after the gear."""

    source: str
    previous: float | None
    """The value that the dof has without the motor."""

    is_overridden: bool
    """Whether the previous value takes precedence."""

    @property
    def differs(self) -> bool:
        """Whether the dof has another value without the motor."""
        return self.previous is not None and not math.isclose(
            self.previous, self.value, rel_tol=RELATIVE_TOLERANCE
        )


def _values_at_dof(dof: Dof, choice: ChosenActuator, motor: MotorSection) -> Iterator[_ValueAtDof]:
    """Yields the motor's value for each quantity of a dof that the motor has."""
    gear = abs(float(choice.parameters.get("gear", 1.0)))
    # A motor that a glob assigns yields to any value of `joints`; a motor assigned by name yields only to an
    # entry with the dof's own name.
    overridden_quantities = dof.named if choice.motor_named else dof.given
    for quantity, value, source in _output_values(motor, choice.type):
        value_at_dof = value * gear ** GEAR_EXPONENTS[quantity]
        previous = getattr(dof.dynamics, quantity)
        yield _ValueAtDof(quantity, value_at_dof, source, previous, quantity in overridden_quantities)


def report_overridden(
    overridden: Sequence[OverriddenValue], choices: Mapping[str, ChosenActuator], log: Diagnostics
) -> None:
    """Reports the motors' values that the configuration overrides (I-MOTOR)."""
    if not overridden:
        return
    text = f"the configuration overrides values of motors: {name_list(value.text for value in overridden)}"
    by_glob = [value.dof for value in overridden if not choices[value.dof].motor_named]
    hint = "leave the value out to use the motor's"
    if by_glob:
        motor = choices[by_glob[0]].motor
        hint += (
            f", or name the motor for the joint: actuators: {{{yaml_key(by_glob[0])}: {{motor: {motor}}}}}"
        )
    log.report("I-MOTOR", text, WHERE, hint)


def _output_values(motor: MotorSection, actuator_type: str) -> Iterator[tuple[str, float, str]]:
    """Yields (quantity of a dof, value at the motor's output, source) for each quantity that a motor has.

    Back-EMF counts as damping, unless the actuator is a dcmotor, for which MuJoCo computes it.
    """
    values = motor.values
    for quantity in ("damping", "friction", "armature", "effort", "velocity"):
        parts = [quantity]
        if quantity == "damping" and actuator_type != "dcmotor":
            parts.append("back_emf")
        if quantity == "armature" and quantity not in values:
            parts = ["rotor_inertia"]
        used_values = [values[name] for name in parts if name in values]
        if not used_values:
            continue
        total = sum(value.value for value in used_values)
        if parts == ["rotor_inertia"]:
            # The rotor's inertia is given at the rotor: reflect it through the motor's own gearbox.
            total *= values["gear"].value ** 2
            used_values.append(values["gear"])
        yield quantity, total, "; ".join(dict.fromkeys(map(_source_text, used_values)))


def _source_text(value: MotorValue) -> str:
    """Returns the source of a value and its kind, as `kinds_of` reads it."""
    return f"{value.source} ({value.kind})"


def kinds_of(source: str) -> list[str]:
    """Returns the kinds (measured, identified, datasheet) that the text of a source names."""
    return re.findall(r" \((measured|identified|datasheet)\)(?:; |\Z)", source)


def parameters_with_motor(dof: str, choice: ChosenActuator, motors: Motors) -> ParametersWithMotor:
    """Returns the parameters of an actuator, completed by its motor. The motor's kv is used only if its kp
    is; its torque constant and resistance only if no `nominal` takes precedence."""
    if not choice.motor:
        return ParametersWithMotor(choice.parameters)
    values = motors[choice.motor].values
    parameters = dict(choice.parameters)
    user_set = {name for name in parameters if not choice.motor_named or choice.origin.get(name) == dof}
    origins: dict[str, str] = {}
    overridden: list[OverriddenValue] = []
    for parameter in _motor_parameters(choice.type, values):
        if parameter.quantity not in values:
            continue
        motor_value = values[parameter.quantity]
        set_names = [name for name in (parameter.name, *parameter.alternatives) if name in user_set]
        if not set_names:
            # Alternatives that a glob gave are dropped; those that the motor set are kept.
            for name in set(parameter.alternatives) - origins.keys():
                parameters.pop(name, None)
            parameters[parameter.name] = parameter.value
            origins[parameter.name] = f"motor {choice.motor}: {_source_text(motor_value)}"
        elif parameters[set_names[0]] != parameter.value:
            text = (
                f"{parameter.quantity} of {dof} ({motor_value.value:.6g}; `actuators` gives {set_names[0]})"
            )
            overridden.append(OverriddenValue(dof, text))
    return ParametersWithMotor(parameters, tuple(origins.items()), tuple(overridden))


class _MotorParameter(NamedTuple):
    """A parameter of an actuator that a quantity of a motor sets."""

    quantity: str
    name: str
    alternatives: tuple[str, ...]
    """Other parameters that exclude it."""

    value: Any


def _motor_parameters(actuator_type: str, values: Mapping[str, MotorValue]) -> Iterator[_MotorParameter]:
    """Yields the parameters that motors can set on an actuator of this type, even those whose quantity this
    motor does not have."""
    numbers = {name: value.value for name, value in values.items()}
    if actuator_type in SERVOS:
        yield _MotorParameter("kp", "kp", (), numbers.get("kp"))
        # The motor's kv fits only the motor's kp, so a kp of the user excludes it.
        if "kp" in numbers:
            yield _MotorParameter("kv", "kv", ("dampratio", "kp"), numbers.get("kv"))
    elif actuator_type == "dcmotor":
        yield _MotorParameter(
            "torque_constant", "motorconst", ("nominal",), (numbers.get("torque_constant"),)
        )
        yield _MotorParameter("resistance", "resistance", ("nominal",), numbers.get("resistance"))
        # A dcmotor is controlled by its voltage.
        volts = numbers.get("voltage", 0.0)
        yield _MotorParameter("voltage", "ctrlrange", (), (-volts, volts))
