"""Configuration of `actuators`: what drives the dofs that a glob matches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from stages.robot.keys import Flag, Keys, NonNegative, Number, Positive, Text, example, invalid, not_yet

DynamicsName = Literal["none", "integrator", "filter", "filterexact", "muscle", "user"]
ActuatorName = Literal["none", "motor", "position", "velocity", "general"]

PARAMETERS: Mapping[str, tuple[str, ...]] = {
    "none": (),
    "motor": (),
    "position": ("kp", "kv", "dampratio"),
    "velocity": ("kv",),
    "general": ("gaintype", "biastype", "dyntype", "gainprm", "biasprm", "dynprm"),
}
"""Type → the fields that only some types have; every type but none has the others."""

SHARED = ("gear", "ctrlrange", "forcerange", "gravcomp")
"""Fields of every type but none."""


def _ascending(pair: tuple[float, float]) -> tuple[float, float]:
    if not pair[0] < pair[1]:
        raise invalid("must be [lower, upper] with lower < upper")
    return pair


def _not_zero(value: float) -> float:
    if value == 0:
        raise invalid("must not be 0")
    return value


Pair = Annotated[tuple[Number, Number], AfterValidator(_ascending)]
Parameters = Annotated[tuple[Number, ...], Field(min_length=1, max_length=10)]


class ActuatorKeys(Keys):
    """What drives the dofs that a glob matches. May be given as the name of a type alone. What is null comes
    from an earlier entry that matches, of the same type, or is chosen by Linkwright."""

    type: Annotated[ActuatorName | None, example("position")] = None
    """none: nothing, also not what the source has; motor: the control is the torque or force; position: a
    servo that holds a value; velocity: a servo that holds a speed; general: MuJoCo's own parameters. null: as
    in an earlier entry that matches."""

    gear: Annotated[Annotated[Number, AfterValidator(_not_zero)] | None, example(50)] = None
    """Ratio of the actuator's motion to the dof's [-]; null: 1. The control and the parameters are those of
    the actuator, before the gear."""

    kp: Annotated[Positive | None, example(80)] = None
    """Of position: stiffness [N m/rad or N/m]. null: estimated for each dof, so that the robot's weight moves
    it by less than 0.01 rad or 1 mm anywhere in its range."""

    kv: Annotated[NonNegative | None, example(2)] = None
    """Of position and velocity: damping [N m s/rad or N s/m]; null: estimated."""

    dampratio: Annotated[NonNegative | None, example(1)] = None
    """Of position: damping ratio [-] of the dof at `home`, from which `kv` follows; null: 1."""

    ctrlrange: Annotated[Pair | None, example([-1, 1])] = None
    """Range of the control [rad, m, rad/s, m/s, N m or N]; null: the limits of the dof, its velocity, or
    its effort."""

    forcerange: Annotated[Pair | None, example([-12, 12])] = None
    """Range of the actuator's force [N m or N], beside the effort of the dof, which always counts; null: no
    other."""

    gravcomp: Annotated[Annotated[Number, Field(ge=0, le=1)] | None, example(1)] = None
    """Share [-] of the weight of the links beyond the dof that the actuator holds by itself; null: 0."""

    gaintype: Annotated[Literal["fixed", "affine", "muscle", "user"] | None, example("fixed")] = None
    """Of general: as MuJoCo's attribute of that name."""

    biastype: Annotated[Literal["none", "affine", "muscle", "user"] | None, example("affine")] = None
    """Of general: as MuJoCo's attribute of that name."""

    dyntype: Annotated[DynamicsName | None, example("none")] = None
    """Of general: as MuJoCo's attribute of that name."""

    gainprm: Annotated[Parameters | None, example([100])] = None
    """Of general: as MuJoCo's attribute of that name."""

    biasprm: Annotated[Parameters | None, example([0, -100, -10])] = None
    """Of general: as MuJoCo's attribute of that name."""

    dynprm: Annotated[Parameters | None, example([1])] = None
    """Of general: as MuJoCo's attribute of that name."""

    encoder: Annotated[Flag | None, example(True)] = None
    """Whether sensors measure the actuator's length and speed: `<actuator>_pos` and `<actuator>_vel`; null:
    as in an earlier entry that matches, else not."""

    force: Annotated[Flag | None, example(True)] = None
    """Whether a sensor measures the actuator's force: `<actuator>_force`; null: as in an earlier entry that
    matches, else not."""

    motor: Text | None = not_yet(None)
    """A motor of the library."""

    @model_validator(mode="after")
    def _of_the_type(self) -> Self:
        if self.type is None:
            return self
        allowed = (*PARAMETERS[self.type], *(SHARED if self.type != "none" else ()))
        wrong = [name for name in self.given() if name not in allowed]
        if self.type == "none":
            wrong += [name for name in ("encoder", "force") if getattr(self, name)]
        if wrong:
            takes = f"takes {', '.join(allowed)}" if allowed else "takes nothing else"
            raise invalid(f"type {self.type} {takes}; not {', '.join(wrong)}")
        if self.kv is not None and self.dampratio is not None:
            raise invalid("kv and dampratio exclude each other")
        return self

    def given(self) -> dict[str, Any]:
        """The parameters that have a value, without the type."""
        names = (*SHARED, *dict.fromkeys(name for row in PARAMETERS.values() for name in row))
        return {name: value for name in names if (value := getattr(self, name)) is not None}


def _name_alone(value: Any) -> Any:
    return {"type": value} if isinstance(value, str) else value


ActuatorChoice = Annotated[
    ActuatorKeys, BeforeValidator(_name_alone, json_schema_input_type=ActuatorKeys | ActuatorName)
]
