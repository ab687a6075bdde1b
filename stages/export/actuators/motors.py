"""What motors of the library give the dofs that they drive, and their actuators.

A motor's values are at its output. Where a `gear` lies between it and the dof, forces are multiplied by the
ratio, speeds divided by it, and inertia and damping multiplied by its square (equal power on both sides).

What is more specific wins: an entry with the dof's own name, then a motor that is named for the dof, then
globs, those of the keys before a motor's, then the source.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.actuators.choices import WHERE, Wanted
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.actuation import SERVOS, Supplied
from linkwright.stages.robot.model.robot import Dof
from linkwright.stages.robot.text.globs import as_key, listed

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.motor_section import MotorSection, MotorValue

Motors = Mapping[str, "MotorSection"]

POWERS = {"damping": 2, "friction": 1, "armature": 2, "effort": 1, "velocity": -1}
"""Quantity of a dof → the power of the gear by which it is multiplied."""

SAME = 1e-9
"""Values that differ by less than this share are the same."""


@dataclass(frozen=True, slots=True)
class Overruled:
    """A value of a motor that loses: the quantity of `dof`, in words, the motor's value, and what stays."""

    dof: str
    words: str


@dataclass(frozen=True, slots=True)
class Equipped:
    """An actuator's parameters with those of its motor. `sources`: (parameter, where its value comes from)
    of these; `overruled`: the motor's values that lose."""

    parameters: Mapping[str, Any]
    sources: tuple[tuple[str, str], ...] = ()
    overruled: tuple[Overruled, ...] = ()


def supplied(
    dofs: Sequence[Dof], wanted: Mapping[str, Wanted], motors: Motors, log: Diagnostics
) -> tuple[list[Supplied], list[Overruled]]:
    """What the motors of these dofs give them, and the values that lose to the key `joints`. I-MOTOR says
    what the motors replace."""
    gifts, overruled, replaced = [], [], []
    for dof in dofs:
        choice = wanted.get(dof.name)
        if choice is None or not choice.motor:
            continue
        gear = abs(float(choice.parameters.get("gear", 1.0)))
        for quantity, value, source in _at_output(motors[choice.motor], choice.type):
            here = value * gear ** POWERS[quantity]
            before = getattr(dof.dynamics, quantity)
            differs = before is not None and not math.isclose(before, here, rel_tol=SAME)
            if quantity in (dof.named if choice.motor_named else dof.given):
                if differs:
                    words = f"{quantity} of {dof.name} ({here:.6g}; `joints` gives {before:.6g})"
                    overruled.append(Overruled(dof.name, words))
                continue
            if differs:
                replaced.append(f"{quantity} of {dof.name} ({before:.6g} → {here:.6g})")
            gifts.append(Supplied(dof.name, quantity, here, f"motor {choice.motor}: {source}"))
    if replaced:
        text = f"motors take the place of what the source or a glob of `joints` says: {listed(replaced)}"
        log.report("I-MOTOR", text, WHERE, "what `joints` gives under the joint's own name stays")
    return gifts, overruled


def report_overruled(overruled: Sequence[Overruled], wanted: Mapping[str, Wanted], log: Diagnostics) -> None:
    """I-MOTOR for the values of motors that lose."""
    if not overruled:
        return
    text = f"values of motors that lose to the configuration: {listed(one.words for one in overruled)}"
    by_glob = [one.dof for one in overruled if not wanted[one.dof].motor_named]
    hint = "leave the value out to have the motor's"
    if by_glob:
        motor = wanted[by_glob[0]].motor
        hint += f", or name the motor for the joint: actuators: {{{as_key(by_glob[0])}: {{motor: {motor}}}}}"
    log.report("I-MOTOR", text, WHERE, hint)


def _at_output(motor: MotorSection, kind: str) -> Iterator[tuple[str, float, str]]:
    """(quantity of a dof, value, source). What resists a motor on a voltage is part of its damping, unless
    the actuator is a DC motor, which has it by itself."""
    values = motor.values
    for quantity in ("damping", "friction", "armature", "effort", "velocity"):
        parts = [quantity]
        if quantity == "damping" and kind != "dcmotor":
            parts.append("back_emf")
        if quantity == "armature" and quantity not in values:
            parts = ["rotor_inertia"]
        there = [values[name] for name in parts if name in values]
        if not there:
            continue
        total = sum(value.value for value in there)
        if parts == ["rotor_inertia"]:
            total *= values["gear"].value ** 2
            there.append(values["gear"])
        yield quantity, total, "; ".join(dict.fromkeys(map(_sourced, there)))


def _sourced(value: MotorValue) -> str:
    return f"{value.source} ({value.kind})"


def equipped(dof: str, wanted: Wanted, motors: Motors) -> Equipped:
    """The parameters of an actuator with those that its motor gives. A kv of the motor belongs to its kp, and
    `nominal` is in place of its constants."""
    if not wanted.motor:
        return Equipped(wanted.parameters)
    values = motors[wanted.motor].values
    given = dict(wanted.parameters)
    keeps = {name for name in given if not wanted.motor_named or wanted.origin.get(name) == dof}
    sources: dict[str, str] = {}
    overruled: list[Overruled] = []

    def take(quantity: str, parameter: str, rivals: tuple[str, ...], value: Any) -> None:
        """The motor's value, unless one of the `rivals` is kept."""
        rival = next((name for name in (parameter, *rivals) if name in keeps), None)
        if rival is None:
            for name in set(rivals) - sources.keys():
                given.pop(name, None)
            given[parameter] = value
            sources[parameter] = f"motor {wanted.motor}: {_sourced(values[quantity])}"
        elif given[rival] != value:
            words = f"{quantity} of {dof} ({values[quantity].value:.6g}; `actuators` gives {rival})"
            overruled.append(Overruled(dof, words))

    for quantity, parameter, rivals, value in _offered(wanted.type, values):
        if quantity in values:
            take(quantity, parameter, rivals, value)
    return Equipped(given, tuple(sources.items()), tuple(overruled))


def _offered(kind: str, values: Mapping[str, MotorValue]) -> Iterator[tuple[str, str, tuple[str, ...], Any]]:
    """(quantity of the motor, parameter, other parameters that exclude it, value) for a type of actuator."""
    value = {name: one.value for name, one in values.items()}
    if kind in SERVOS:
        yield "kp", "kp", (), value.get("kp")
        if "kp" in value:
            yield "kv", "kv", ("dampratio", "kp"), value.get("kv")
    elif kind == "dcmotor":
        yield "torque_constant", "motorconst", ("nominal",), (value.get("torque_constant"),)
        yield "resistance", "resistance", ("nominal",), value.get("resistance")
        volts = value.get("voltage", 0.0)
        yield "voltage", "ctrlrange", (), (-volts, volts)
