"""Compares the actuators of a USD, in MuJoCo's own schema, with the robot's."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from linkwright.stages.formats.usd.actuator_facts import ActuatorAttributes, supported_actuators
from linkwright.stages.formats.usd.joint_facts import MUJOCO
from linkwright.stages.formats.usd.names import UsdNames
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.actuation import Actuator
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate.findings import differs, named

TARGET = "mjc:target"
"""The relationship of an actuator to the prim of its joint."""

RELATIVE_TOLERANCE = 1e-11
"""Relative tolerance of numbers, of which files have twelve digits."""

Value = float | str | tuple[float, ...]
"""The value of an attribute."""


@dataclass(frozen=True, slots=True)
class ReadUsdActuator:
    """An actuator of a USD."""

    joint: str
    """The name of the joint's prim; "" without a joint, and all names if there are several."""

    values: Mapping[str, Value]
    """The attributes in MuJoCo's namespace."""


def read_actuators(prims: Sequence[Any]) -> dict[str, ReadUsdActuator]:
    """Returns the actuators among the prims, by name."""
    return {prim.GetName(): _read(prim) for prim in prims if prim.GetTypeName() == "MjcActuator"}


def _read(prim: Any) -> ReadUsdActuator:
    targets = prim.GetRelationship(TARGET).GetTargets() if prim.HasRelationship(TARGET) else []
    authored = {attribute.GetName(): attribute.Get() for attribute in prim.GetAuthoredAttributes()}
    values = {name: _plain(value) for name, value in authored.items() if name.startswith(MUJOCO)}
    return ReadUsdActuator(" ".join(target.name for target in targets), values)


def _plain(value: Any) -> Value:
    """Returns a value of USD as text, as a number, or as numbers."""
    if isinstance(value, str):
        return value
    return float(value) if isinstance(value, int | float) else tuple(map(float, value))


def actuator_findings(
    read: Mapping[str, ReadUsdActuator], robot: Robot, names: UsdNames, expected: Sequence[Actuator]
) -> Iterator[Finding]:
    """Yields the differences of each actuator that the schema knows, and the actuators that must not
    exist."""
    dofs = {dof.name for joint in robot.joints for dof in joint.dofs if dof.kind in ("turn", "slide")}
    expected_values = {
        name: (actuator, attributes) for name, actuator, attributes in supported_actuators(expected, dofs)
    }
    for name in sorted(read.keys() | expected_values.keys()):
        element = named("def", name)
        if name not in read or name not in expected_values:
            message = (
                "is not an actuator"
                if name in expected_values
                else "is an actuator that the robot does not have"
            )
            yield Finding(element, "MjcActuator", message)
            continue
        actuator, attributes = expected_values[name]
        joint = names.joints[actuator.dof]
        if read[name].joint != joint:
            yield differs(element, TARGET, read[name].joint or "none", joint)
        yield from _differences(element, read[name].values, attributes)


def _differences(
    element: str, read: Mapping[str, Value], attributes: ActuatorAttributes
) -> Iterator[Finding]:
    expected_values: dict[str, Value] = {**attributes.numbers, **attributes.tokens, **attributes.arrays}
    for attribute in sorted(read.keys() | expected_values.keys()):
        if not _is_same(read.get(attribute), expected_values.get(attribute)):
            yield differs(element, attribute, read.get(attribute), expected_values.get(attribute))


def _is_same(actual: Value | None, expected: Value | None) -> bool:
    """Tells whether two values are equal, within the tolerance if they are numbers, or both missing."""
    if isinstance(actual, tuple) and isinstance(expected, tuple):
        return len(actual) == len(expected) and all(map(_is_same, actual, expected))
    # The tolerance of an infinite number would be infinite.
    if isinstance(actual, float) and isinstance(expected, float) and math.isfinite(expected):
        return abs(actual - expected) <= RELATIVE_TOLERANCE * abs(expected)
    return actual == expected
