"""Defines the configuration `actuators`: the actuators of the dofs that a glob matches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from linkwright.stages.robot.quantity_keys import Coordinate
from linkwright.stages.robot.section import (
    Flag,
    NonNegative,
    Number,
    Positive,
    Section,
    Text,
    example,
    invalid,
)

DynamicsType = Literal["none", "integrator", "filter", "filterexact", "muscle", "user"]
ActuatorTypeName = Literal[
    "none", "motor", "position", "velocity", "intvelocity", "damper", "pid", "dcmotor", "general"
]

DC_MOTOR = (
    "motorconst", "resistance", "nominal", "saturation", "inductance", "cogging", "thermal", "lugre",
)  # fmt: skip
"""Parameters of a DC motor, with MuJoCo's names."""

FIELDS_OF_TYPE: Mapping[str, tuple[str, ...]] = {
    "none": (),
    "motor": ("forcerange",),
    "position": ("kp", "kv", "dampratio", "forcerange"),
    "velocity": ("kv", "forcerange"),
    "intvelocity": ("kp", "kv", "dampratio", "forcerange"),
    "damper": ("kv", "forcerange"),
    "pid": ("kp", "kv", "dampratio", "ki", "imax", "slewmax", "forcerange"),
    "dcmotor": DC_MOTOR,
    "general": ("gaintype", "biastype", "dyntype", "gainprm", "biasprm", "dynprm", "forcerange"),
}
"""Type → its fields that some other types lack."""

COMMON_FIELDS = ("gear", "ctrlrange", "gravcomp", "delay", "interp")
"""Fields of all types except `none`."""


def fields_of(kind: str) -> tuple[str, ...]:
    """Returns the fields that a type of actuator has."""
    return (*FIELDS_OF_TYPE[kind], *(COMMON_FIELDS if kind != "none" else ()))


def _check_ascending(pair: tuple[float, float]) -> tuple[float, float]:
    if not pair[0] < pair[1]:
        raise invalid("must be [lower, upper] with lower < upper")
    return pair


def _check_not_zero(value: float) -> float:
    if value == 0:
        raise invalid("must not be 0")
    return value


Range = Annotated[tuple[Number, Number], AfterValidator(_check_ascending)]
ControlRange = Annotated[tuple[Coordinate, Coordinate], AfterValidator(_check_ascending)]
Parameters = Annotated[tuple[Number, ...], Field(min_length=1, max_length=10)]


class ActuatorSection(Section):
    """What drives the dofs that a glob matches. May be given as the name of a type alone. A null field
    takes its value from an earlier entry that matches, unless that entry is of another type; otherwise
    Linkwright chooses it."""

    type: Annotated[ActuatorTypeName | None, example("position")] = None
    """none: no actuator, not even the source's; motor: the control is the torque or force; position: a servo
    that holds a value; velocity: a servo that holds a speed; intvelocity: a servo whose target moves at the
    speed of the control; damper: the control is a share of the damping `kv`; pid: a position servo with an
    integral part (MuJoCo 3.12); dcmotor: the control is the voltage of a DC motor (MuJoCo 3.7); general:
    MuJoCo's own parameters. null: as in an earlier entry that matches, otherwise that of the motor; only an
    entry of nothing but sensors needs neither."""

    gear: Annotated[Annotated[Number, AfterValidator(_check_not_zero)] | None, example(50)] = None
    """Ratio of the actuator's motion to the dof's [-]; null: 1. The control and the parameters are those of
    the actuator, before the gear."""

    kp: Annotated[Positive | None, example(80)] = None
    """For position, intvelocity and pid: stiffness [N m/rad or N/m]. null: estimated for each dof, so that
    the robot's weight moves it by less than 0.01 rad or 1 mm anywhere in its range (0.1 rad or 10 mm if it
    carries a standing robot), as far as the time step allows, and never so stiff that it reaches its effort
    within 0.1 rad or 10 mm. Poses near a singular pose of a loop do not count."""

    kv: Annotated[NonNegative | None, example(2)] = None
    """For position, velocity, intvelocity, damper and pid: damping [N m s/rad or N s/m]; null: estimated."""

    dampratio: Annotated[NonNegative | None, example(1)] = None
    """For position, intvelocity and pid: damping ratio [-] of the dof at `home`, which determines `kv`; null:
    1."""

    ki: Annotated[Positive | None, example(20)] = None
    """For pid: force per error and second [N m/(rad s) or N/(m s)], which removes the sag over time; null: no
    integral part."""

    imax: Annotated[Positive | None, example(2)] = None
    """For pid: the largest integral of the error [rad s or m s] that counts; null: no limit."""

    slewmax: Annotated[Positive | None, example(3)] = None
    """For pid: the largest speed [rad/s or m/s] at which the target follows the control; null: no limit."""

    ctrlrange: Annotated[ControlRange | None, example([-1, 1])] = None
    """Range of the control [rad, m, rad/s, m/s, N m, N or V; for a damper -]; null: depending on the type the
    limits of the dof, its velocity, its effort, the voltage of the motor, or for a damper [0, 1]."""

    forcerange: Annotated[Range | None, example([-12, 12])] = None
    """Range of the actuator's force [N m or N], in addition to the effort of the dof, which always counts;
    null: only the effort. Not for dcmotor, which has `saturation`."""

    gravcomp: Annotated[Annotated[Number, Field(ge=0, le=1)] | None, example(1)] = None
    """Share [-] of the weight of the links beyond the dof that the actuator compensates; null: 0."""

    delay: Annotated[Positive | None, example(0.01)] = None
    """Time [s] after which the control acts (MuJoCo 3.5); null: at once. After a reset, also to a keyframe,
    the control counts as 0 for that time."""

    interp: Annotated[Literal["zoh", "linear", "cubic"] | None, example("linear")] = None
    """Interpolation of a delayed control between time steps; null: zoh, the last control."""

    gaintype: Annotated[Literal["fixed", "affine", "muscle", "user"] | None, example("fixed")] = None
    """For general: as MuJoCo's attribute of that name."""

    biastype: Annotated[Literal["none", "affine", "muscle", "user"] | None, example("affine")] = None
    """For general: as MuJoCo's attribute of that name."""

    dyntype: Annotated[DynamicsType | None, example("none")] = None
    """For general: as MuJoCo's attribute of that name."""

    gainprm: Annotated[Parameters | None, example([100])] = None
    """For general: as MuJoCo's attribute of that name."""

    biasprm: Annotated[Parameters | None, example([0, -100, -10])] = None
    """For general: as MuJoCo's attribute of that name."""

    dynprm: Annotated[Parameters | None, example([1])] = None
    """For general: as MuJoCo's attribute of that name."""

    encoder: Annotated[Flag | None, example(True)] = None
    """Whether sensors measure the actuator's length and speed: `<actuator>_pos` and `<actuator>_vel`; null:
    as in an earlier entry that matches, otherwise false."""

    force: Annotated[Flag | None, example(True)] = None
    """Whether a sensor measures the actuator's force: `<actuator>_force`; null: as in an earlier entry that
    matches, otherwise false."""

    motorconst: Annotated[
        Annotated[tuple[Positive, ...], Field(min_length=1, max_length=2)] | None, example([0.05])
    ] = None
    """For dcmotor: torque per current [N m/A], and voltage per speed [V s/rad] if that differs."""

    resistance: Annotated[Positive | None, example(2)] = None
    """For dcmotor: resistance of the winding [ohm]."""

    nominal: Annotated[tuple[Positive, Positive, Positive] | None, example([12, 3, 5])] = None
    """For dcmotor, in place of `motorconst` and `resistance`: voltage [V], and the stall torque [N m] and
    no-load speed [rad/s] at this voltage."""

    saturation: Annotated[
        Annotated[tuple[NonNegative, ...], Field(min_length=1, max_length=3)] | None, example([3])
    ] = None
    """For dcmotor: as MuJoCo's attribute of that name."""

    inductance: Annotated[
        Annotated[tuple[NonNegative, ...], Field(min_length=1, max_length=2)] | None, example([0.001])
    ] = None
    """For dcmotor: as MuJoCo's attribute of that name."""

    cogging: Annotated[tuple[Number, Number, Number] | None, example([0.01, 6, 0])] = None
    """For dcmotor: as MuJoCo's attribute of that name."""

    thermal: Annotated[
        tuple[Number, Number, Number, Number, Number, Number] | None, example([10, 5, 1, 0.004, 25, 25])
    ] = None
    """For dcmotor: as MuJoCo's attribute of that name."""

    lugre: Annotated[
        tuple[Number, Number, Number, Number, Number] | None, example([100, 1, 0.1, 0.15, 0.1])
    ] = None
    """For dcmotor: as MuJoCo's attribute of that name."""

    motor: Annotated[Text | None, example("sts3215")] = None
    """A motor of the library, or your own: `motors/<name>.yaml` beside `robot/`. The dof gets the motor's
    known inertia, damping, friction, torque and speed. Values in `joints` or this mapping under the dof's own
    name override the motor's, and so do values under globs, unless the motor is named for the dof itself.
    `gear` is then a gear between the motor and the dof."""

    @model_validator(mode="after")
    def _check_fields(self) -> Self:
        # The type may come from another entry, or from the motor: `choices` checks the merged fields.
        if self.type is None:
            return self
        allowed = fields_of(self.type)
        wrong = [name for name in self.explicit() if name not in allowed]
        if self.type == "none":
            wrong += [name for name in ("encoder", "force", "motor") if getattr(self, name)]
        if wrong:
            takes = f"takes {', '.join(allowed)}" if allowed else "takes nothing else"
            raise invalid(f"type {self.type} {takes}; not {', '.join(wrong)}")
        if self.kv is not None and self.dampratio is not None:
            raise invalid("kv and dampratio exclude each other")
        if self.type == "damper" and self.ctrlrange is not None and self.ctrlrange[0] < 0:
            raise invalid("the control of a damper is never negative: ctrlrange begins at 0 or above")
        return self

    def explicit(self) -> dict[str, Any]:
        """Returns the parameters that have a value, without the type, the motor and the sensors."""
        names = (*COMMON_FIELDS, *dict.fromkeys(name for row in FIELDS_OF_TYPE.values() for name in row))
        return {name: value for name in names if (value := getattr(self, name)) is not None}

    @property
    def only_measures(self) -> bool:
        """Whether the entry only adds sensors, and chooses no actuator."""
        measures = self.encoder is not None or self.force is not None
        return measures and self.type is None and self.motor is None and not self.explicit()


def _entry_of_name(value: Any) -> Any:
    return {"type": value} if isinstance(value, str) else value


ActuatorChoice = Annotated[
    ActuatorSection,
    BeforeValidator(_entry_of_name, json_schema_input_type=ActuatorSection | ActuatorTypeName),
]
