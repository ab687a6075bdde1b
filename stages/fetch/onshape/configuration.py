"""Checks the user's values for an assembly's configuration, and encodes them as Onshape does.

Onshape lists the parameters of a configuration, so all errors are reported at once, with the allowed values.
The text is encoded here, since the server's own encoder would cost a call.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import orjson

from linkwright.stages.formats.onshape_configuration import (
    encode_value,
    join_configuration,
    split_configuration,
)
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import ProtocolError, SourceError
from linkwright.stages.robot.text.globs import did_you_mean
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.units import SI, UNITS, Measure

ParameterKind = Literal["Enum", "Boolean", "Quantity", "String"]

_CONFIGURATION_KEY = "source.configuration"

_KIND_BY_TYPE: Mapping[str, ParameterKind] = {kind.upper(): kind for kind in get_args(ParameterKind)}
"""`parameterType` of a parameter in a reply → its kind."""

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z°]*)\s*")
"""A number, and a unit or nothing."""

_MAX_BOUND = 1e300
"""Largest size of a bound: Onshape writes the largest double for "no bound"."""

_BOUND_TOLERANCE = 1e-9
"""Relative tolerance of bounds, which may have another unit than the value."""

_MIN_COMPARED_SIZE = 1e-6
"""Smallest size, in units of the bounds, for the relative tolerance: smaller values have the tolerance of
this size."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a configuration."""

    id: str
    name: str
    kind: ParameterKind
    options: Mapping[str, str]
    """Id → label of each option of an Enum."""

    quantity_type: str = ""
    """The type of a Quantity, such as "LENGTH", "ANGLE", "INTEGER" or "REAL"."""

    unit: str = ""
    """The unit of the bounds; "" for plain numbers."""

    lower_bound: float | None = None
    """The smallest value of a Quantity; None without a bound."""

    upper_bound: float | None = None
    """The largest value of a Quantity; None without a bound."""

    @property
    def allowed_values(self) -> str:
        """The allowed values, in words."""
        match self.kind:
            case "Enum":
                return ", ".join(dict.fromkeys(self.options.values()))
            case "Boolean":
                return "true, false"
            case "String":
                return "text"
            case "Quantity":
                bounds = [
                    f"{word} {bound:g} {self.unit}".rstrip()
                    for word, bound in (("from", self.lower_bound), ("to", self.upper_bound))
                    if bound is not None
                ]
                number_with_unit = f'a number with its unit, such as "10 {self.unit}"'
                number_text = {"INTEGER": "a whole number", "REAL": "a number"}.get(
                    self.quantity_type, number_with_unit
                )
                return " ".join([number_text, *bounds])


def read_parameters(body: bytes) -> tuple[Parameter, ...]:
    """Returns the parameters that a reply lists; those of unknown kinds take any text. Raises ProtocolError
    if the reply is not a list of parameters."""
    try:
        records = orjson.loads(body)["configurationParameters"]
        return tuple(_parameter(record.get("message", record)) for record in records)
    except orjson.JSONDecodeError:
        msg = "the reply with the configuration parameters is not JSON, or was cut short"
        raise ProtocolError(msg, hint="run the same command again") from None
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        msg = f"the reply with the configuration parameters has an unknown format ({error})"
        raise ProtocolError(msg, hint="leave source.configuration out; the API may have changed") from None


def encode_settings(base: str, settings: Mapping[str, Any], parameters: Sequence[Parameter]) -> str:
    """Returns Onshape's text for the configuration `base`, which is in the address, with `settings` (name or
    id of a parameter → value).

    Raises SourceError with every parameter that does not exist or is set twice, and every value that is not
    allowed.
    """
    log = Diagnostics()
    texts_by_id: dict[str, str] = {}
    for name, value in settings.items():
        place = f"{_CONFIGURATION_KEY}.{name}"
        parameter = _find_parameter(name, place, parameters, log)
        if parameter is None:
            continue
        if parameter.id in texts_by_id:
            msg = "the parameter is given twice, by name and by id"
            log.report("E-CONFIGURATION", msg, place, "remove one of the two")
            continue
        try:
            texts_by_id[parameter.id] = _CONVERTERS[parameter.kind](parameter, value)
        except ValueError as error:
            log.report("E-CONFIGURATION", str(error), place, f"allowed: {parameter.allowed_values}")
    if log.problems:
        msg = f"invalid configuration of the assembly: {count(len(log.problems), 'problem')}"
        raise SourceError(msg, _CONFIGURATION_KEY, problems=log.problems)
    encoded_texts = split_configuration(base) | {
        parameter_id: encode_value(text) for parameter_id, text in texts_by_id.items()
    }
    # In the order of the assembly's parameters, so that the same configuration is always the same request.
    rank = {parameter.id: index for index, parameter in enumerate(parameters)}
    return join_configuration(
        dict(sorted(encoded_texts.items(), key=lambda item: rank.get(item[0], len(rank))))
    )


def _parameter(record: Mapping[str, Any]) -> Parameter:
    """Returns the parameter that a record of a reply describes. Some replies wrap records in `message`."""
    type_name = str(record.get("parameterType") or "").upper()
    # Without a `parameterType`, a class such as BTMConfigurationParameterEnum names the kind.
    class_names = f"{record.get('btType') or ''}{record.get('typeName') or ''}"
    kinds = (
        kind for name, kind in _KIND_BY_TYPE.items() if name == type_name or f"Parameter{kind}" in class_names
    )
    options = [option.get("message", option) for option in record.get("options") or ()]
    bounds = record.get("rangeAndDefault") or {}
    bounds = bounds.get("message", bounds)
    return Parameter(
        id=str(record["parameterId"]),
        name=str(record.get("parameterName") or record["parameterId"]),
        kind=next(kinds, "String"),
        options={
            str(option["option"]): str(option.get("optionName") or option["option"]) for option in options
        },
        quantity_type=str(record.get("quantityType") or ""),
        unit=str(bounds.get("units") or ""),
        lower_bound=_bound(bounds.get("minValue")),
        upper_bound=_bound(bounds.get("maxValue")),
    )


def _bound(value: Any) -> float | None:
    return None if value is None or abs(float(value)) > _MAX_BOUND else float(value)


def _find_parameter(
    name: str, place: str, parameters: Sequence[Parameter], log: Diagnostics
) -> Parameter | None:
    """Returns the parameter with this id, else with this name. Reports E-CONFIGURATION and returns None if
    there is no such parameter, or several."""
    for attribute in ("id", "name"):
        matches = [parameter for parameter in parameters if getattr(parameter, attribute) == name]
        if len(matches) == 1:
            return matches[0]
        if matches:
            ids = ", ".join(parameter.id for parameter in matches)
            msg = f"{len(matches)} parameters have this name"
            log.report("E-CONFIGURATION", msg, place, f"use the id: {ids}")
            return None
    names = [parameter.name for parameter in parameters]
    suggestion = did_you_mean(name, names)
    hint = f"{suggestion} " if suggestion else ""
    hint += (
        f"it has: {', '.join(names)}"
        if names
        else "the assembly has no parameters: leave source.configuration out"
    )
    log.report("E-CONFIGURATION", "the assembly has no such parameter", place, hint)
    return None


def _option_id(parameter: Parameter, value: Any) -> str:
    """Returns the id of an option, from its id or its label."""
    if isinstance(value, bool):
        msg = f"must be one of the options, not {str(value).lower()} (put it in quotes if it is text)"
        raise ValueError(msg)
    text = str(value)
    if text in parameter.options:
        return text
    ids = [option_id for option_id, label in parameter.options.items() if label == text]
    if len(ids) == 1:
        return ids[0]
    msg = f"{text!r} is not allowed"
    if ids:
        msg = f"{len(ids)} options have this label, so name one by its id: {', '.join(ids)}"
    raise ValueError(msg)


def _boolean_text(parameter: Parameter, value: Any) -> str:
    del parameter
    if isinstance(value, bool):
        return str(value).lower()
    if value in ("true", "false"):
        return str(value)
    msg = f"must be true or false (given {value!r})"
    raise ValueError(msg)


def _string_text(parameter: Parameter, value: Any) -> str:
    del parameter
    if isinstance(value, str):
        return value
    msg = f"must be text (given {value!r}): quote it"
    raise ValueError(msg)


def _quantity_text(parameter: Parameter, value: Any) -> str:
    """Returns a quantity as text: from a number in SI, or from a text of a number with its unit."""
    if isinstance(value, bool):
        msg = f"must be a number (given {str(value).lower()})"
        raise ValueError(msg)
    match = _QUANTITY.fullmatch(str(value))
    if match is None or not math.isfinite(float(match[1])):
        msg = f"must be a number with its unit (given {value!r})"
        raise ValueError(msg)
    number, unit = float(match[1]), match[2]
    measures: Mapping[str, Measure] = {"LENGTH": "length", "ANGLE": "angle"}
    measure = measures.get(parameter.quantity_type)
    if measure is not None:
        return _length_or_angle_text(parameter, measure, number, unit or SI[measure])
    if parameter.quantity_type in ("INTEGER", "REAL"):
        if unit or (parameter.quantity_type == "INTEGER" and number != int(number)):
            kind = "whole" if parameter.quantity_type == "INTEGER" else "plain"
            msg = f"must be a {kind} number (given {value!r})"
            raise ValueError(msg)
        _require_within_bounds(parameter, number, 1.0, repr(value))
        return f"{number:.0f}" if parameter.quantity_type == "INTEGER" else repr(number)
    # The server converts masses, forces, times and so on; a number without a unit is in the parameter's.
    return f"{number!r} {unit or parameter.unit}".rstrip()


def _length_or_angle_text(parameter: Parameter, measure: Measure, number: float, unit: str) -> str:
    """Returns a length or angle as text with its unit; raises ValueError for a unit of another measure."""
    if unit not in UNITS:
        msg = f"unknown unit {unit!r}"
        raise ValueError(msg)
    unit_size, unit_measure = UNITS[unit]
    if unit_measure != measure:
        nouns = {"length": "a length", "angle": "an angle"}
        msg = f"must be {nouns[measure]}, and {unit} is the unit of {nouns[unit_measure]}"
        raise ValueError(msg)
    # Bounds in a unit that is unknown here are taken for SI.
    bound_unit_size, _ = UNITS.get(parameter.unit, (1.0, measure))
    _require_within_bounds(parameter, number * unit_size, bound_unit_size, f"{number:g} {unit}")
    return f"{number!r} {unit}"


def _require_within_bounds(parameter: Parameter, value: float, unit_size: float, value_text: str) -> None:
    """Raises ValueError if `value` [SI] is outside of the parameter's bounds. `unit_size`: the size of the
    bounds' unit [SI]; `value_text`: the value for the message."""
    tolerance = _BOUND_TOLERANCE * max(abs(value), unit_size * _MIN_COMPARED_SIZE)
    lower, upper = parameter.lower_bound, parameter.upper_bound
    is_too_small = lower is not None and value < lower * unit_size - tolerance
    is_too_large = upper is not None and value > upper * unit_size + tolerance
    if is_too_small or is_too_large:
        msg = f"{value_text} is too {'small' if is_too_small else 'large'}"
        raise ValueError(msg)


_CONVERTERS: Mapping[ParameterKind, Callable[[Parameter, Any], str]] = {
    "Enum": _option_id,
    "Boolean": _boolean_text,
    "String": _string_text,
    "Quantity": _quantity_text,
}
"""Kind of a parameter → the function that converts a value to Onshape's text. It raises ValueError for a
value that is not allowed."""
