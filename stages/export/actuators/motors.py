"""What motors of the library give the dofs that they drive, and their actuators.

A motor's values are at its output. Where a `gear` lies between it and the dof, forces are multiplied by the
ratio, speeds divided by it, and inertia and damping multiplied by its square (equal power on both sides).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from stages.export.actuators.choices import WHERE, Wanted
from stages.robot.actuation import SERVOS, Supplied
from stages.robot.diagnostics import Diagnostics
from stages.robot.globs import listed
from stages.robot.model import Dof

if TYPE_CHECKING:
    from stages.export.motor_keys import MotorKeys, MotorValue

Motors = Mapping[str, "MotorKeys"]

POWERS = {"damping": 2, "friction": 1, "armature": 2, "effort": 1, "velocity": -1}
"""Quantity of a dof → the power of the gear by which it is multiplied."""


def supplied(
    dofs: Sequence[Dof], wanted: Mapping[str, Wanted], motors: Motors, log: Diagnostics
) -> list[Supplied]:
    """What the motors of these dofs give them, but for what the configuration gives. I-MOTOR tells what of
    the source they replace."""
    found, replaced = [], []
    for dof in dofs:
        one = wanted.get(dof.name)
        if one is None or not one.motor:
            continue
        gear = abs(float(one.parameters.get("gear", 1.0)))
        for quantity, value, source in _at_output(motors[one.motor], one.type):
            if quantity in dof.given:
                continue
            here = value * gear ** POWERS[quantity]
            before = getattr(dof.dynamics, quantity)
            if before is not None and before != here:
                replaced.append(f"{quantity} of {dof.name} ({before:.6g} → {here:.6g})")
            found.append(Supplied(dof.name, quantity, here, f"motor {one.motor}: {source}"))
    if replaced:
        text = f"motors take the place of what the source says: {listed(replaced)}"
        log.report("I-MOTOR", text, WHERE, "what `joints` gives stays")
    return found


def _at_output(motor: MotorKeys, kind: str) -> Iterator[tuple[str, float, str]]:
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
        total = sum(one.value for one in there)
        if parts == ["rotor_inertia"]:
            total *= values["gear"].value ** 2
            there.append(values["gear"])
        yield quantity, total, "; ".join(dict.fromkeys(map(_told, there)))


def _told(value: MotorValue) -> str:
    return f"{value.source} ({value.kind})"


def completed(wanted: Wanted, motors: Motors) -> tuple[dict[str, Any], tuple[tuple[str, str], ...]]:
    """The parameters of an actuator with those that its motor gives where the configuration is silent, and
    (parameter, source) of these. A kv of the motor belongs to its kp."""
    given = dict(wanted.parameters)
    if not wanted.motor:
        return given, ()
    values = motors[wanted.motor].values
    sources: dict[str, str] = {}

    def take(quantity: str, parameter: str, value: Any) -> None:
        if parameter not in given and quantity in values:
            given[parameter] = value
            sources[parameter] = f"motor {wanted.motor}: {_told(values[quantity])}"

    if wanted.type in SERVOS and "kp" not in given:
        take("kp", "kp", values["kp"].value if "kp" in values else None)
        if "kp" in given and "dampratio" not in given:
            take("kv", "kv", values["kv"].value if "kv" in values else None)
    elif wanted.type == "dcmotor" and "nominal" not in given:
        for quantity, parameter in (("torque_constant", "motorconst"), ("resistance", "resistance")):
            if quantity in values:
                value = values[quantity].value
                take(quantity, parameter, (value,) if parameter == "motorconst" else value)
        if "ctrlrange" not in given and "voltage" in values:
            take("voltage", "ctrlrange", (-values["voltage"].value, values["voltage"].value))
    return given, tuple(sources.items())
