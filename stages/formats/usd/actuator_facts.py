"""Converts actuators to the attributes of MuJoCo's USD schema `MjcActuator`.

The force of an actuator is gain · control + bias; its length is the value of its dof [rad or m] times the
gear.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from linkwright.stages.formats.usd.names import identifiers
from linkwright.stages.robot.model.actuation import Actuator

_TOKENS = {
    "dyntype": ("mjc:dynType", ("none", "integrator", "filter", "filterexact", "muscle", "user")),
    "gaintype": ("mjc:gainType", ("fixed", "affine", "muscle", "user")),
    "biastype": ("mjc:biasType", ("none", "affine", "muscle", "user")),
}
"""Attribute of MJCF → attribute of the schema, and the tokens that the schema allows."""

_ARRAYS = {"dynprm": "mjc:dynPrm", "gainprm": "mjc:gainPrm", "biasprm": "mjc:biasPrm"}
"""Attribute of MJCF → attribute of the schema, for arrays of numbers."""

_LENGTHS = {"mjc:dynPrm": 10, "mjc:gainPrm": 10, "mjc:biasPrm": 10, "mjc:gear": 6}
"""Attribute of the schema → the number of its values: readers accept no fewer."""


@dataclass(frozen=True, slots=True)
class ActuatorAttributes:
    """The attributes of an actuator in the schema, by name: numbers, tokens, and arrays of numbers."""

    numbers: Mapping[str, float]
    tokens: Mapping[str, str]
    arrays: Mapping[str, tuple[float, ...]]


def supported_actuators(
    actuators: Sequence[Actuator], dofs: Collection[str]
) -> Iterator[tuple[str, Actuator, ActuatorAttributes]]:
    """Yields (name of the prim, actuator, attributes) for each actuator of these dofs that the schema
    supports."""
    names = identifiers(actuator.name for actuator in actuators)
    for actuator in actuators:
        attributes = actuator_attributes(actuator)
        if attributes is not None and actuator.dof in dofs:
            yield names[actuator.name], actuator, attributes


def actuator_attributes(actuator: Actuator) -> ActuatorAttributes | None:
    """Returns an actuator's attributes in the schema, without the integral term of a PID; None if the schema
    has no such actuator."""
    tokens, arrays = _force_law(actuator)
    if any(tokens[name] not in allowed for name, (_, allowed) in _TOKENS.items() if name in tokens):
        return None
    numbers: dict[str, float] = {}
    ranges = {"ctrl": actuator.control, "force": actuator.force, "act": _source_range(actuator, "actrange")}
    for name, limits in ranges.items():
        if limits is not None:
            numbers |= {f"mjc:{name}Range:min": limits[0], f"mjc:{name}Range:max": limits[1]}
    if actuator.gear != 1.0:
        arrays["gear"] = (actuator.gear,)
    array_attributes = {**_ARRAYS, "gear": "mjc:gear"}
    return ActuatorAttributes(
        numbers,
        {_TOKENS[name][0]: token for name, token in tokens.items()},
        {array_attributes[name]: _padded(array_attributes[name], values) for name, values in arrays.items()},
    )


def _force_law(actuator: Actuator) -> tuple[dict[str, str], dict[str, tuple[float, ...]]]:
    """Returns the tokens and arrays of the force by MJCF attribute, as MuJoCo's shortcut elements (such as
    `position`) set them."""
    kp, kv = actuator.kp or 0.0, actuator.kv or 0.0
    match actuator.type:
        # The integral term of a PID is left out (see `actuator_attributes`).
        case "position" | "pid":
            return {"biastype": "affine"}, {"gainprm": (kp,), "biasprm": (0.0, -kp, -kv)}
        # The activation of the integrator is the target position.
        case "intvelocity":
            return (
                {"dyntype": "integrator", "biastype": "affine"},
                {"gainprm": (kp,), "biasprm": (0.0, -kp, -kv)},
            )
        case "velocity":
            return {"biastype": "affine"}, {"gainprm": (kv,), "biasprm": (0.0, 0.0, -kv)}
        case "damper":
            return {"gaintype": "affine"}, {"gainprm": (0.0, 0.0, -kv)}
        case "dcmotor":
            # The schema does not have this type of gain, so `actuator_attributes` returns None.
            return {"gaintype": "dcmotor"}, {}
        case _:
            terms = dict(actuator.terms)
            return (
                {name: terms[name] for name in _TOKENS if name in terms},
                {name: _numbers(terms[name]) for name in _ARRAYS if name in terms},
            )


def _source_range(actuator: Actuator, name: str) -> tuple[float, float] | None:
    """Returns the range in an attribute of the source's actuator; None without the attribute."""
    text = dict(actuator.terms).get(name)
    if text is None:
        return None
    low, high = _numbers(text)
    return low, high


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(map(float, text.split()))


def _padded(name: str, values: tuple[float, ...]) -> tuple[float, ...]:
    """Returns the values with zeros added to the length of an attribute of the schema."""
    return (*values, *(0.0,) * (_LENGTHS[name] - len(values)))
