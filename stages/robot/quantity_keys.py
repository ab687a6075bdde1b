"""Reads keys that are lengths or angles: numbers in SI, or texts with a unit, such as "25 mm" and "-90
deg"."""

import math
import re
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainSerializer,
    Strict,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)

from linkwright.stages.robot.section import invalid
from linkwright.stages.robot.text.units import SI, UNITS, Measure

if TYPE_CHECKING:  # the model imports numpy
    from linkwright.stages.robot.model.dofs import DofKind

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*(\S.*?)?\s*")

EXAMPLES = {"length": "25 mm", "angle": "-90 deg"}
"""A text of each measure, for messages."""

_UNIT_NAMES = {"length": "nm, um, mm, cm, m, in, ft, ...", "angle": "deg, rad, rev"}


class TypedNumber(float):
    """A number in SI that the user typed with a unit."""

    measure: Measure
    """What the unit measures."""
    typed: str
    """The text that the user typed."""


def quantity(text: str, *measures: Measure) -> TypedNumber:
    """Returns the number in SI of a text such as "25 mm". Raises the error of `section.invalid` for a text
    that is not a finite number with a unit of one of the measures."""
    examples = " or ".join(f"{EXAMPLES[measure]!r}" for measure in measures)
    kinds = " or ".join(f"{'an' if measure == 'angle' else 'a'} {measure}" for measure in measures)
    expected = (
        f"must be a number in {' or '.join(SI[measure] for measure in measures)}, or {kinds} as {examples}"
    )
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise invalid(expected)
    number, unit = match.groups()
    if unit is None:
        # YAML takes "-.04" for text, and the configuration's messages say so.
        as_text = number.startswith(("-.", "+."))
        raise invalid(expected if as_text else f"{expected}: without quotes, or with a unit")
    unit_entry = UNITS.get(unit)
    if unit_entry is None or unit_entry[1] not in measures:
        names = "; ".join(_UNIT_NAMES[measure] for measure in measures)
        is_what = "unknown" if unit_entry is None else f"a unit of {unit_entry[1]}"
        raise invalid(f"{expected}: {unit!r} is {is_what}; units are {names}")
    typed_number = TypedNumber(float(number) * unit_entry[0])
    if not math.isfinite(typed_number):
        raise invalid(f"{expected}: it is too large")
    typed_number.measure, typed_number.typed = unit_entry[1], text
    return typed_number


def _length(value: Any) -> Any:
    return float(quantity(value, "length")) if isinstance(value, str) else value


def _angle(value: Any) -> Any:
    return float(quantity(value, "angle")) if isinstance(value, str) else value


def _degrees(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    typed_number = quantity(value, "angle")
    return round(float(typed_number) / UNITS["deg"][0], 12)


def _coordinate(value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
    return quantity(value, "angle", "length") if isinstance(value, str) else handler(value)


def _typed_text(value: float | None) -> float | str | None:
    return value.typed if isinstance(value, TypedNumber) else value


Typed = float | str
"""The types that a key accepts: a number, or a text with a unit."""

Length = Annotated[float, Strict(), BeforeValidator(_length, json_schema_input_type=Typed)]
"""A length [m]."""

Angle = Annotated[float, Strict(), BeforeValidator(_angle, json_schema_input_type=Typed)]
"""An angle [rad]."""

Degrees = Annotated[float, Strict(), BeforeValidator(_degrees, json_schema_input_type=Typed)]
"""An angle [deg], where MuJoCo has degrees whatever its compiler says."""

Coordinate = Annotated[
    float,
    Strict(),
    WrapValidator(_coordinate, json_schema_input_type=Typed),
    PlainSerializer(_typed_text, return_type=float | str),
]
"""A value of a joint [rad or m]. Only the robot tells which of the two, so a `TypedNumber` keeps the typed
text until then."""

PositiveLength = Annotated[Length, Field(gt=0)]
NonNegativeLength = Annotated[Length, Field(ge=0)]
PositiveAngle = Annotated[Angle, Field(gt=0)]

Position = tuple[Length, Length, Length]
"""x, y and z [m]."""

Turns = tuple[Angle, Angle, Angle]
"""Roll, pitch and yaw [rad]."""


def _ascending(pair: tuple[float | None, float | None]) -> tuple[float | None, float | None]:
    lower, upper = pair
    if lower is not None and upper is not None and not lower < upper:
        raise invalid("must be [lower, upper] with lower < upper")
    return pair


Range = Annotated[tuple[Coordinate | None, Coordinate | None], AfterValidator(_ascending)]
"""(lower, upper) [rad or m]; None is an open side."""


def misfit(value: object, kind: "DofKind") -> str:
    """Returns why the unit of a value does not suit a dof of this kind; "" if it does, or if the value has no
    unit."""
    if not isinstance(value, TypedNumber) or kind == "free":
        return ""
    measure = measure_of(kind)
    return "" if value.measure == measure else f"{value.typed!r} is no {measure}"


def measure_of(kind: "DofKind") -> Measure:
    """Returns the measure of the values of a dof of this kind, which is not "free"."""
    return "length" if kind == "slide" else "angle"


def unit_hint(kind: "DofKind") -> str:
    """Returns the hint for a value of a dof of this kind."""
    measure = measure_of(kind)
    return f"give it in {SI[measure]}, or as {EXAMPLES[measure]!r}"
