"""Checks the user's values of an assembly's configuration and encodes them as Onshape does.

The document lists its parameters, so all errors are reported at once, with the allowed values. The
text is encoded here, since the server's own encoder would cost a call.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import orjson

from linkwright.stages.formats.onshape_configuration import encoded, joined, split
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import ProtocolError, SourceError
from linkwright.stages.robot.text.globs import did_you_mean
from linkwright.stages.robot.text.units import SI, UNITS, Measure

Kind = Literal["Enum", "Boolean", "Quantity", "String"]
_KEY = "source.configuration"
_KINDS: Mapping[str, Kind] = {kind.upper(): kind for kind in get_args(Kind)}
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z°]*)\s*")
_BOUND_TOLERANCE = 1e-9
"""Relative tolerance of bounds, which may be typed in another unit than the value."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a configuration."""

    id: str
    name: str
    kind: Kind
    options: Mapping[str, str]
    """Id → label, for an Enum."""

    measure: str = ""
    """"LENGTH", "ANGLE", "INTEGER", "REAL", ..., for a Quantity."""

    unit: str = ""
    """The unit of `least` and `most`; "" for plain numbers."""

    least: float | None = None
    """Lower bound of a Quantity; None without a bound."""

    most: float | None = None
    """Upper bound of a Quantity; None without a bound."""

    @property
    def allowed(self) -> str:
        """Describes the allowed values in words."""
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
                    for word, bound in (("from", self.least), ("to", self.most))
                    if bound is not None
                ]
                expected = {"INTEGER": "a whole number", "REAL": "a number"}.get(self.measure)
                return " ".join([expected or f'a number with its unit, such as "10 {self.unit}"', *bounds])


def read(body: bytes) -> tuple[Parameter, ...]:
    """Returns the parameters in a reply. Raises ProtocolError for any other reply. Parameters of unknown
    kinds take any text."""
    try:
        records = orjson.loads(body)["configurationParameters"]
        return tuple(_parameter(record.get("message", record)) for record in records)
    except orjson.JSONDecodeError:
        msg = "the reply with the configuration parameters is not JSON, or was cut short"
        raise ProtocolError(msg, hint="run the same command again") from None
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        msg = f"the reply with the configuration parameters has an unknown format ({error})"
        raise ProtocolError(msg, hint="leave source.configuration out; the API may have changed") from None


def encode(base: str, settings: Mapping[str, Any], parameters: Sequence[Parameter]) -> str:
    """Returns Onshape's text for `settings` (name or id → value) over `base`, the text in the address.

    Raises SourceError with every parameter that does not exist or is given twice, and every value that is not
    allowed.
    """
    log = Diagnostics()
    values_by_id: dict[str, str] = {}
    for name, value in settings.items():
        place = f"{_KEY}.{name}"
        parameter = _find(name, place, parameters, log)
        if parameter is None:
            continue
        if parameter.id in values_by_id:
            text = "the parameter is given twice, by name and by id"
            log.report("E-CONFIGURATION", text, place, "remove one of the two")
            continue
        try:
            values_by_id[parameter.id] = _CHECKS[parameter.kind](parameter, value)
        except ValueError as error:
            log.report("E-CONFIGURATION", str(error), place, f"allowed: {parameter.allowed}")
    if log.problems:
        count = f"{len(log.problems)} problems" if len(log.problems) > 1 else "1 problem"
        msg = f"invalid configuration of the assembly: {count}"
        raise SourceError(msg, _KEY, problems=log.problems)
    values = split(base) | {name: encoded(value) for name, value in values_by_id.items()}
    # One order, whatever the order of the keys: the same configuration is the same request.
    rank = {parameter.id: index for index, parameter in enumerate(parameters)}
    return joined(dict(sorted(values.items(), key=lambda item: rank.get(item[0], len(rank)))))


def _parameter(record: Mapping[str, Any]) -> Parameter:
    kinds = str(record.get("parameterType") or "").upper()
    text = f"{record.get('btType') or ''}{record.get('typeName') or ''}"
    kinds_named = (kind for name, kind in _KINDS.items() if name == kinds or f"Parameter{kind}" in text)
    options = [option.get("message", option) for option in record.get("options") or ()]
    bounds = record.get("rangeAndDefault") or {}
    bounds = bounds.get("message", bounds)
    return Parameter(
        id=str(record["parameterId"]),
        name=str(record.get("parameterName") or record["parameterId"]),
        kind=next(kinds_named, "String"),
        options={
            str(option["option"]): str(option.get("optionName") or option["option"]) for option in options
        },
        measure=str(record.get("quantityType") or ""),
        unit=str(bounds.get("units") or ""),
        least=_bound(bounds.get("minValue")),
        most=_bound(bounds.get("maxValue")),
    )


def _bound(value: Any) -> float | None:
    # Onshape writes "no bound" as the largest double.
    return None if value is None or abs(float(value)) > 1e300 else float(value)


def _find(name: str, place: str, parameters: Sequence[Parameter], log: Diagnostics) -> Parameter | None:
    for attribute in ("id", "name"):
        hits = [parameter for parameter in parameters if getattr(parameter, attribute) == name]
        if len(hits) == 1:
            return hits[0]
        if hits:
            ids = ", ".join(parameter.id for parameter in hits)
            msg = f"{len(hits)} parameters have this name"
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


def _option(parameter: Parameter, value: Any) -> str:
    if isinstance(value, bool):
        msg = f"must be one of the options, not {str(value).lower()} (put it in quotes if it is text)"
        raise ValueError(msg)
    text = str(value)
    if text in parameter.options:
        return text
    hits = [option for option, label in parameter.options.items() if label == text]
    if len(hits) == 1:
        return hits[0]
    msg = f"{text!r} is not allowed"
    if hits:
        msg = f"{len(hits)} options have this label, so name one by its id: {', '.join(hits)}"
    raise ValueError(msg)


def _boolean(parameter: Parameter, value: Any) -> str:
    del parameter
    if isinstance(value, bool):
        return str(value).lower()
    if value in ("true", "false"):
        return str(value)
    msg = f"must be true or false (given {value!r})"
    raise ValueError(msg)


def _string(parameter: Parameter, value: Any) -> str:
    del parameter
    if isinstance(value, str):
        return value
    msg = f"must be text (given {value!r}): quote it"
    raise ValueError(msg)


def _quantity(parameter: Parameter, value: Any) -> str:
    """Returns a quantity as text: from a number in SI, or from text of a number with its unit."""
    if isinstance(value, bool):
        msg = f"must be a number (given {str(value).lower()})"
        raise ValueError(msg)
    match = _QUANTITY.fullmatch(str(value))
    if match is None or not math.isfinite(float(match[1])):
        msg = f"must be a number with its unit (given {value!r})"
        raise ValueError(msg)
    number, unit = float(match[1]), match[2]
    measures: Mapping[str, Measure] = {"LENGTH": "length", "ANGLE": "angle"}
    measure = measures.get(parameter.measure)
    if measure is not None:
        return _measured(parameter, measure, number, unit or SI[measure])
    if parameter.measure in ("INTEGER", "REAL"):
        if unit or (parameter.measure == "INTEGER" and number != int(number)):
            kind = "whole" if parameter.measure == "INTEGER" else "plain"
            msg = f"must be a {kind} number (given {value!r})"
            raise ValueError(msg)
        _within(parameter, number, 1.0, repr(value))
        return f"{number:.0f}" if parameter.measure == "INTEGER" else repr(number)
    # Masses, forces, times, ...: the server knows their units, and a bare number is in its own.
    return f"{number!r} {unit or parameter.unit}".rstrip()


def _measured(parameter: Parameter, measure: Measure, number: float, unit: str) -> str:
    size, kind = UNITS.get(unit, (0.0, measure))
    if not size:
        msg = f"unknown unit {unit!r}"
        raise ValueError(msg)
    if kind != measure:
        article = {"length": "a length", "angle": "an angle"}
        msg = f"must be {article[measure]}, and {unit} is the unit of {article[kind]}"
        raise ValueError(msg)
    _within(parameter, number * size, UNITS.get(parameter.unit, (1.0, measure))[0], f"{number:g} {unit}")
    return f"{number!r} {unit}"


def _within(parameter: Parameter, value: float, size: float, shown: str) -> None:
    """Raises ValueError if `value` (SI) is outside of the bounds, which are in units of `size` (SI)."""
    slack = _BOUND_TOLERANCE * max(abs(value), size * 1e-6)
    low = parameter.least is not None and value < parameter.least * size - slack
    high = parameter.most is not None and value > parameter.most * size + slack
    if low or high:
        msg = f"{shown} is too {'small' if low else 'large'}"
        raise ValueError(msg)


_CHECKS: Mapping[Kind, Callable[[Parameter, Any], str]] = {
    "Enum": _option,
    "Boolean": _boolean,
    "String": _string,
    "Quantity": _quantity,
}
