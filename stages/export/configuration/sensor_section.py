"""Defines the configuration `sensors`: the robot's sensors by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from linkwright.stages.robot.quantity_keys import (
    Coordinate,
    Degrees,
    Position,
    PositiveLength,
    Turns,
    TypedNumber,
)
from linkwright.stages.robot.section import Count, Section, Text, example, invalid
from linkwright.stages.robot.text.globs import matches_glob
from linkwright.stages.robot.text.units import Measure

SensorName = Literal[
    "joint",
    "actuator",
    "imu",
    "force",
    "torque",
    "force_torque",
    "touch",
    "rangefinder",
    "frame",
    "camera",
]

MEASURES: Mapping[str, Mapping[str, str]] = {
    "joint": {
        "pos": "jointpos",
        "vel": "jointvel",
        "actuator_force": "jointactuatorfrc",
        "limit_pos": "jointlimitpos",
        "limit_vel": "jointlimitvel",
        "limit_force": "jointlimitfrc",
    },
    "actuator": {"pos": "actuatorpos", "vel": "actuatorvel", "force": "actuatorfrc"},
    "imu": {
        "gyro": "gyro",
        "accelerometer": "accelerometer",
        "quat": "framequat",
        "velocimeter": "velocimeter",
        "magnetometer": "magnetometer",
    },
    "force": {"force": "force"},
    "torque": {"torque": "torque"},
    "force_torque": {"force": "force", "torque": "torque"},
    "touch": {"force": "touch"},
    "rangefinder": {"distance": "rangefinder"},
    "frame": {
        "pos": "framepos",
        "quat": "framequat",
        "xaxis": "framexaxis",
        "yaxis": "frameyaxis",
        "zaxis": "framezaxis",
        "linvel": "framelinvel",
        "angvel": "frameangvel",
        "linacc": "framelinacc",
        "angacc": "frameangacc",
    },
    "camera": {"projection": "camprojection"},
}
"""Type → measurement → MuJoCo's element."""

DEFAULT_MEASURES: Mapping[str, tuple[str, ...]] = {
    "joint": ("pos", "vel"),
    "imu": ("gyro", "accelerometer", "quat"),
    "frame": ("pos", "quat"),
}
"""Type → its measurements if `measure` is null; other types then have all their measurements."""

ACCELERATIONS = ("linacc", "angacc")
"""Measurements that MuJoCo only has in the axes of the world."""

WITHOUT_CUTOFF = ("quat", "xaxis", "yaxis", "zaxis")
"""Orientations, which have no largest value."""

_FIELDS_OF_MOUNT = ("frame", "xyz", "rpy")

FIELDS_OF_TYPE: Mapping[str, tuple[str, ...]] = {
    "joint": ("joints", "measure"),
    "actuator": ("actuators", "measure"),
    "imu": (*_FIELDS_OF_MOUNT, "measure"),
    "force": _FIELDS_OF_MOUNT,
    "torque": _FIELDS_OF_MOUNT,
    "force_torque": _FIELDS_OF_MOUNT,
    "touch": (*_FIELDS_OF_MOUNT, "size"),
    "rangefinder": _FIELDS_OF_MOUNT,
    "frame": (*_FIELDS_OF_MOUNT, "measure", "relative_to"),
    "camera": (*_FIELDS_OF_MOUNT, "fovy", "resolution", "sees"),
}
"""Type → its fields, in addition to `noise` and `cutoff`, which all types have."""


MEASURES_WITH_UNIT: Mapping[str, tuple[Measure, ...]] = {
    "joint.pos": ("angle", "length"),
    "joint.limit_pos": ("angle", "length"),
    "actuator.pos": ("angle", "length"),
    "rangefinder.distance": ("length",),
    "frame.pos": ("length",),
}
"""Measurement → the kinds of units with which its values may be typed."""


def _by_any_measure(value: Any) -> Any:
    return {"*": value} if isinstance(value, int | float | str) and not isinstance(value, bool) else value


def _as_size(value: Any) -> Any:
    return (value,) if isinstance(value, int | float | str) and not isinstance(value, bool) else value


def _check_size(size: tuple[float, ...]) -> tuple[float, ...]:
    if len(size) not in (1, 3):
        raise invalid("must be the radius of a ball, or [x, y, z], the lengths of a box")
    return size


def _not_negative(value: float) -> float:
    if value < 0:
        raise invalid("must be 0 or above")
    return value


_Amount = Annotated[Coordinate, AfterValidator(_not_negative)]

ByMeasure = Annotated[
    dict[Text, _Amount],
    BeforeValidator(_by_any_measure, json_schema_input_type=dict[Text, _Amount] | _Amount),
]
"""Measurement, or a glob on its name → a number; a number alone applies to all."""

Size = Annotated[
    tuple[PositiveLength, ...],
    AfterValidator(_check_size),
    BeforeValidator(_as_size, json_schema_input_type=tuple[PositiveLength, ...] | PositiveLength),
]


class SensorSection(Section):
    """A sensor, or several of one kind. May be given as the name of a type alone. The MJCF's sensor has the
    name of the entry, of types that measure several things with what it measures: `imu_gyro`, `wrist_force`;
    of a glob on joints or actuators also with the name of each: `legs_knee_pos`."""

    type: Annotated[SensorName, example("imu")]
    """joint: its value and more; actuator: its length, speed and force; imu: angular velocity, acceleration
    and orientation; force, torque and force_torque: the force and torque that the parent link exerts on this
    link, at the frame; touch: the contact force on a link; rangefinder: the distance along z, or -1 if there
    is nothing; frame: its pose and motion; camera: an image."""

    joints: Annotated[Text | None, example("*knee*")] = None
    """For joint: a name or glob on dofs. null: all."""

    actuators: Annotated[Text | None, example("*knee*")] = None
    """For actuator: a name or glob on actuators. null: all."""

    frame: Annotated[Text | None, example("imu_mount")] = None
    """For mounted sensors: the frame or link of the robot that carries the sensor. null: the frame or link
    with the sensor's name."""

    xyz: Annotated[Position, example([0, 0, 0.02])] = (0, 0, 0)
    """For mounted sensors: position in the frame [m]."""

    rpy: Annotated[Turns, example([0, 1.57, 0])] = (0, 0, 0)
    """For mounted sensors: roll, pitch and yaw in the frame [rad]. A rangefinder and a camera look along
    z."""

    relative_to: Annotated[Text | None, example("torso")] = None
    """For frame: the frame or link relative to which, and in whose axes, it is measured. null: the world."""

    measure: Annotated[tuple[Text, ...] | None, example(["gyro", "accelerometer"])] = None
    """Measurements, in this order. joint: pos, vel, actuator_force, limit_pos, limit_vel, limit_force;
    actuator: pos, vel, force; imu: gyro, accelerometer, quat, velocimeter, magnetometer; frame: pos, quat,
    xaxis, yaxis, zaxis, linvel, angvel, linacc, angacc. null: for joint pos and vel; for actuator all; for
    imu gyro, accelerometer and quat; for frame pos and quat. linacc includes gravity, as an accelerometer
    does: at rest it is 9.81 m/s² upwards."""

    size: Annotated[Size | None, example([0.1, 0.06, 0.02])] = None
    """For touch: radius of a ball, or lengths of a box [m], around the frame, in which contacts count. null:
    a box around the colliders of the link."""

    fovy: Annotated[Annotated[Degrees, Field(gt=0, lt=180)], example(60)] = 45
    """For camera: vertical field of view [deg], as in MuJoCo."""

    resolution: tuple[Count, Count] = (640, 480)
    """For camera: width and height of the image [pixels]."""

    sees: Annotated[tuple[Text, ...], example(["tool"])] = ()
    """For camera: frames or links whose positions in its image are measured [pixels]."""

    noise: Annotated[ByMeasure | None, example({"gyro": 0.01, "accelerometer": 0.05})] = None
    """Standard deviation, in the unit of the measured quantity: a single value for all quantities, or a value
    for each. MuJoCo only stores it for readers of the model, and adds no noise (it did before 3.1.4). null:
    0."""

    cutoff: Annotated[ByMeasure | None, example({"accelerometer": 160})] = None
    """Largest absolute value, in the unit of the measured quantity: a single value for all quantities, or a
    value for each; orientations have no cutoff. null: no cutoff."""

    @model_validator(mode="after")
    def _check_fields(self) -> Self:
        allowed = (*FIELDS_OF_TYPE[self.type], "noise", "cutoff")
        wrong = [name for name in sorted(self.model_fields_set) if name not in ("type", *allowed)]
        wrong = [name for name in wrong if getattr(self, name) != type(self).model_fields[name].default]
        if wrong:
            raise invalid(f"type {self.type} takes {', '.join(allowed)}; not {', '.join(wrong)}")
        measurable = MEASURES[self.type]
        for name in self.measured:
            if name not in measurable:
                raise invalid(f"type {self.type} measures {', '.join(measurable)}; not {name}")
        if not self.measured:
            raise invalid("measure must name a quantity")
        if len(set(self.measured)) < len(self.measured):
            raise invalid("measure must name each quantity once")
        if self.relative_to is not None and any(name in ACCELERATIONS for name in self.measured):
            raise invalid("linacc and angacc are in the axes of the world: they exclude relative_to")
        self._check_numbers()
        return self

    def _check_numbers(self) -> None:
        for key in ("noise", "cutoff"):
            for glob, value in (getattr(self, key) or {}).items():
                names = [name for name in self.measured if matches_glob(name, glob)]
                if not names:
                    raise invalid(f"{key} names {glob}, but the sensor measures {', '.join(self.measured)}")
                for name in names if isinstance(value, TypedNumber) else ():
                    if value.measure not in MEASURES_WITH_UNIT.get(f"{self.type}.{name}", ()):
                        raise invalid(f"{key}: {name} is no {value.measure}, as {value.typed!r} is")
        for name in self.cutoff or {}:
            if name in WITHOUT_CUTOFF:
                raise invalid(f"cutoff does not apply to {name}, which is an orientation")

    @property
    def measured(self) -> tuple[str, ...]:
        """The measurements, in order."""
        if self.measure is not None:
            return self.measure
        return DEFAULT_MEASURES.get(self.type, tuple(MEASURES[self.type]))

    def noise_of(self, measured: str) -> float:
        """Returns the standard deviation of a measurement, in its unit; 0 if none is set."""
        return float(self.typed("noise", measured))

    def cutoff_of(self, measured: str) -> float:
        """Returns the largest absolute value of a measurement, in its unit; 0 for no limit."""
        return 0.0 if measured in WITHOUT_CUTOFF else float(self.typed("cutoff", measured))

    def typed(self, key: Literal["noise", "cutoff"], measured: str) -> float:
        """Returns the noise or cutoff of a measurement: a `TypedNumber` if it was typed with a unit; 0 if
        none is set."""
        return _last_match(getattr(self, key) or {}, measured)


def _last_match(values: Mapping[str, float], measured: str) -> float:
    """Returns the value of the last glob that matches the measurement; 0 without one."""
    return next(
        (value for glob, value in reversed(list(values.items())) if matches_glob(measured, glob)), 0.0
    )


def _name_alone(value: Any) -> Any:
    return {"type": value} if isinstance(value, str) else value


SensorChoice = Annotated[
    SensorSection, BeforeValidator(_name_alone, json_schema_input_type=SensorSection | SensorName)
]
