"""Defines the configuration `motors`: the values of a motor, with the source of each.

All values except `rotor_inertia` are at the output, behind the motor's own gear.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from linkwright.stages.robot.section import Number, Section, Text, example, invalid
from linkwright.stages.robot.text.globs import did_you_mean

QUANTITIES: Mapping[str, str] = {
    "gear": "-",
    "rotor_inertia": "kg m²",
    "armature": "kg m²",
    "damping": "N m s/rad",
    "back_emf": "N m s/rad",
    "friction": "N m",
    "effort": "N m",
    "velocity": "rad/s",
    "kp": "N m/rad",
    "kv": "N m s/rad",
    "torque_constant": "N m/A",
    "resistance": "ohm",
    "voltage": "V",
}
"""Quantity of a motor → its unit."""

ZERO_ALLOWED = ("damping", "back_emf", "friction", "kv")
"""Quantities that a motor may lack altogether; all others are above 0."""


class MotorValue(Section):
    """A value, and where it comes from."""

    value: Annotated[Number, Field(ge=0), example(0.028)]
    """In SI units, at the motor's output."""

    source: Annotated[Text, example("my test bench, 2 May: pendulum of 0.5 kg")]
    """Where the value comes from: who published it, in which document, and how it was computed from that."""

    kind: Annotated[Literal["measured", "identified", "datasheet"], example("identified")]
    """measured: on the motor; identified: fitted to recordings of its motion; datasheet: from its
    manufacturer."""


class MotorSection(Section):
    """A motor with its gear."""

    title: Annotated[Text, example("My servo, 7.4 V")]
    """The motor's full name, with the voltage for which the values hold."""

    type: Annotated[Literal["motor", "position", "velocity", "intvelocity"], example("position")] = "position"
    """The actuator type of the motor, if `actuators` does not give a type."""

    notes: Annotated[Text | None, example("friction grows with the load, which is left out")] = None
    """What the values leave out."""

    values: Annotated[
        dict[Text, MotorValue],
        example({"armature": {"value": 0.028, "source": "my test bench", "kind": "identified"}}),
    ]
    """Quantity → value. gear [-]; rotor_inertia [kg m²], before the gear; armature [kg m²]; damping [N m
    s/rad], of bearings and gears; back_emf [N m s/rad], the damping by the motor at constant voltage;
    friction [N m]; effort [N m], the stall torque; velocity [rad/s], the no-load speed; kp [N m/rad] and kv
    [N m s/rad], as its own controller has them; torque_constant [N m/A]; resistance [ohm]; voltage [V]."""

    @model_validator(mode="after")
    def _check_quantities(self) -> Self:
        for name, value in self.values.items():
            if name not in QUANTITIES:
                hint = f"{did_you_mean(name, QUANTITIES)} there are {', '.join(QUANTITIES)}"
                raise invalid(f"{name} is not a quantity of a motor: {hint.lstrip()}")
            if value.value == 0 and name not in ZERO_ALLOWED:
                raise invalid(f"{name} must be above 0")
        if "armature" in self.values and "rotor_inertia" in self.values:
            raise invalid(
                "armature and rotor_inertia are the same inertia, after and before the gear: give only one"
            )
        if "rotor_inertia" in self.values and "gear" not in self.values:
            raise invalid("rotor_inertia needs the gear")
        return self
