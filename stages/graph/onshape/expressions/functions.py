"""Defines the functions and constants of expressions, as FeatureScript's math library has them.

Trigonometric functions take angles with a unit, and their inverses give angles.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from linkwright.stages.graph.onshape.expressions.quantity import (
    ANGLE,
    DIMENSIONLESS,
    ExpressionError,
    Quantity,
    Value,
)

Function = Callable[[Sequence[Quantity]], Quantity]

CONSTANTS: Mapping[str, Value] = {"PI": Quantity(math.pi), "true": True, "false": False}

_MAX_ARGUMENTS = 64
_MAX_PLACES = 300


def _angle_function(name: str, compute: Callable[[float], float]) -> Function:
    """Returns a function of an angle."""

    def call(values: Sequence[Quantity]) -> Quantity:
        (value,) = values
        if value.dimension != ANGLE:
            msg = f"{name}() takes an angle, not {value.description}: write its unit, {name}(30 deg)"
            raise ExpressionError(msg)
        return Quantity(compute(value.value))

    return call


def _number_function(name: str, compute: Callable[[float], float], angle: int = 0) -> Function:
    """Returns a function of a plain number, which gives a plain number or (`angle` = 1) an angle."""

    def call(values: Sequence[Quantity]) -> Quantity:
        (value,) = values
        if value.dimension != DIMENSIONLESS:
            msg = f"{name}() takes a number, not {value.description}"
            raise ExpressionError(msg)
        try:
            return Quantity(compute(value.value), angle=Fraction(angle))
        except (ValueError, OverflowError):
            msg = f"{name}({value.value:g}) is not defined"
            raise ExpressionError(msg) from None

    return call


def _same_kind_function(name: str, compute: Callable[[Sequence[float]], float]) -> Function:
    """Returns a function of quantities of the same dimension, which gives a quantity of that dimension."""

    def call(values: Sequence[Quantity]) -> Quantity:
        for other in values[1:]:
            values[0].require_same_dimension(other, f"{name}()")
        return values[0].like(compute([value.value for value in values]))

    return call


def _rounding_function(name: str, compute: Callable[[float], float]) -> Function:
    """Returns a function that rounds a number, or any quantity to multiples of the second quantity."""

    def call(values: Sequence[Quantity]) -> Quantity:
        value, step = values[0], values[1] if len(values) == 2 else Quantity(1.0)
        value.require_same_dimension(step, f"{name}()")
        if step.value == 0.0:
            msg = f"{name}() to multiples of zero"
            raise ExpressionError(msg)
        steps = Quantity(value.value / step.value).checked().value
        return value.like(compute(steps) * step.value)

    return call


def _atan2(values: Sequence[Quantity]) -> Quantity:
    y, x = values
    y.require_same_dimension(x, "atan2()")
    return Quantity(math.atan2(y.value, x.value), angle=Fraction(1))


def _square_root(values: Sequence[Quantity]) -> Quantity:
    (value,) = values
    if value.value < 0:
        msg = "sqrt() of a negative value"
        raise ExpressionError(msg)
    return Quantity(math.sqrt(value.value), value.length / 2, value.angle / 2)


def _to_precision(values: Sequence[Quantity]) -> Quantity:
    """Returns a number rounded to a number of decimal places, which is negative for places before the
    point."""
    places = values[1].value
    if any(value.dimension != DIMENSIONLESS for value in values) or places != int(places):
        msg = "roundToPrecision() takes a number and a whole number of decimal places"
        raise ExpressionError(msg)
    if abs(places) > _MAX_PLACES:
        msg = f"roundToPrecision() to more than {_MAX_PLACES} places"
        raise ExpressionError(msg)
    scale = 10.0 ** abs(places)
    if places < 0:
        return Quantity(_half_up(values[0].value / scale) * scale)
    return Quantity(_half_up(Quantity(values[0].value * scale).checked().value) / scale)


def _clamp(values: Sequence[float]) -> float:
    value, low, high = values
    return min(max(value, low), high)


def _half_up(value: float) -> float:
    return float(math.floor(value + 0.5))


FUNCTIONS: Mapping[str, tuple[int, int, Function]] = {
    **{name: (1, 1, _angle_function(name, getattr(math, name))) for name in ("sin", "cos", "tan")},
    **{name: (1, 1, _number_function(name, getattr(math, name), 1)) for name in ("asin", "acos", "atan")},
    **{
        name: (1, 1, _number_function(name, getattr(math, name)))
        for name in ("sinh", "cosh", "tanh", "exp", "exp2")
    },
    **{name: (1, 1, _number_function(name, getattr(math, name))) for name in ("asinh", "acosh", "atanh")},
    "log": (1, 1, _number_function("log", math.log)),
    "log10": (1, 1, _number_function("log10", math.log10)),
    "atan2": (2, 2, _atan2),
    "sqrt": (1, 1, _square_root),
    "abs": (1, 1, _same_kind_function("abs", lambda values: abs(values[0]))),
    "min": (1, _MAX_ARGUMENTS, _same_kind_function("min", min)),
    "max": (1, _MAX_ARGUMENTS, _same_kind_function("max", max)),
    "hypot": (2, 2, _same_kind_function("hypot", lambda values: math.hypot(*values))),
    "floor": (1, 2, _rounding_function("floor", lambda value: float(math.floor(value)))),
    "ceil": (1, 2, _rounding_function("ceil", lambda value: float(math.ceil(value)))),
    "round": (1, 2, _rounding_function("round", _half_up)),
    "roundToPrecision": (2, 2, _to_precision),
    "clamp": (3, 3, _same_kind_function("clamp", _clamp)),
}
"""Name → (smallest and largest number of values, the function)."""
