"""Describes actuators in the words of MuJoCo's own schema (`MjcActuator`): force = gain · control + bias,
along the dof's value times a gear, in radians and metres."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from linkwright.stages.formats.usd.names import identifiers
from linkwright.stages.robot.model.actuation import Actuator

_WORDS = {
    "dyntype": ("mjc:dynType", ("none", "integrator", "filter", "filterexact", "muscle", "user")),
    "gaintype": ("mjc:gainType", ("fixed", "affine", "muscle", "user")),
    "biastype": ("mjc:biasType", ("none", "affine", "muscle", "user")),
}
"""Attribute of MJCF → attribute of the schema, and the words that the schema knows."""

_ARRAYS = {"dynprm": "mjc:dynPrm", "gainprm": "mjc:gainPrm", "biasprm": "mjc:biasPrm"}

_LENGTHS = {"mjc:dynPrm": 10, "mjc:gainPrm": 10, "mjc:biasPrm": 10, "mjc:gear": 6}
"""Attribute → the number of its values: readers accept no fewer."""


@dataclass(frozen=True, slots=True)
class ActuatorFacts:
    """The attributes of an actuator in the schema, by name: numbers, words, and arrays of numbers."""

    numbers: Mapping[str, float]
    words: Mapping[str, str]
    arrays: Mapping[str, tuple[float, ...]]


def known_actuators(
    actuators: Sequence[Actuator], dofs: Collection[str]
) -> Iterator[tuple[str, Actuator, ActuatorFacts]]:
    """Yields the actuators of these dofs that the schema knows: the name of the prim, the actuator, and its
    facts."""
    names = identifiers(actuator.name for actuator in actuators)
    for actuator in actuators:
        facts = actuator_facts(actuator)
        if facts is not None and actuator.dof in dofs:
            yield names[actuator.name], actuator, facts


def actuator_facts(actuator: Actuator) -> ActuatorFacts | None:
    """Returns an actuator in the schema, without the integral part of a PID; None if the schema does not know
    it."""
    words, arrays = _force(actuator)
    if any(words[name] not in vocabulary for name, (_, vocabulary) in _WORDS.items() if name in words):
        return None
    numbers: dict[str, float] = {}
    ranges = {"ctrl": actuator.control, "force": actuator.force, "act": _pair(actuator, "actrange")}
    for name, ends in ranges.items():
        if ends is not None:
            numbers |= {f"mjc:{name}Range:min": ends[0], f"mjc:{name}Range:max": ends[1]}
    if actuator.gear != 1.0:
        arrays["gear"] = (actuator.gear,)
    keys = {**_ARRAYS, "gear": "mjc:gear"}
    return ActuatorFacts(
        numbers,
        {_WORDS[name][0]: word for name, word in words.items()},
        {keys[name]: _filled(keys[name], values) for name, values in arrays.items()},
    )


def _force(actuator: Actuator) -> tuple[dict[str, str], dict[str, tuple[float, ...]]]:
    """Returns words and arrays of the force, by the attributes of MJCF, as MuJoCo's shortcuts set them."""
    kp, kv = actuator.kp or 0.0, actuator.kv or 0.0
    match actuator.type:
        case "position" | "pid":
            return {"biastype": "affine"}, {"gainprm": (kp,), "biasprm": (0.0, -kp, -kv)}
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
            return {"gaintype": "dcmotor"}, {}
        case _:
            terms = dict(actuator.terms)
            return (
                {name: terms[name] for name in _WORDS if name in terms},
                {name: _numbers(terms[name]) for name in _ARRAYS if name in terms},
            )


def _pair(actuator: Actuator, name: str) -> tuple[float, float] | None:
    text = dict(actuator.terms).get(name)
    if text is None:
        return None
    low, high = _numbers(text)
    return low, high


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(map(float, text.split()))


def _filled(name: str, values: tuple[float, ...]) -> tuple[float, ...]:
    return (*values, *(0.0,) * (_LENGTHS[name] - len(values)))
