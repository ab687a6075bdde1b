"""A number with its dimension, and its arithmetic."""

import math
from dataclasses import dataclass
from fractions import Fraction

from linkwright.stages.robot.text.units import Measure

Dimension = tuple[Fraction, Fraction]
"""Exponents of metre and radian."""

NONE: Dimension = (Fraction(0), Fraction(0))
LENGTH: Dimension = (Fraction(1), Fraction(0))
ANGLE: Dimension = (Fraction(0), Fraction(1))

_NAMES = {NONE: "a number", LENGTH: "a length", ANGLE: "an angle", (Fraction(2), Fraction(0)): "an area"}
_MOST_POWER = 64


class ExpressionError(Exception):
    """An expression without a value; the text gives the reason, to be appended to "…: "."""


class UnknownVariable(ExpressionError):
    """An expression refers to an undefined variable."""

    def __init__(self, name: str) -> None:
        super().__init__(f"the variable #{name} is not known")
        self.name = name


@dataclass(frozen=True, slots=True)
class Quantity:
    """`value` in SI; exponents of metre and radian."""

    value: float
    length: Fraction = Fraction(0)
    angle: Fraction = Fraction(0)

    @property
    def dimension(self) -> Dimension:
        return self.length, self.angle

    @property
    def what(self) -> str:
        """The dimension in words."""
        return _NAMES.get(self.dimension, f"a quantity in m^({self.length})·rad^({self.angle})")

    def checked(self) -> "Quantity":
        """Itself; ExpressionError where the value is not finite."""
        if math.isfinite(self.value):
            return self
        msg = "a value is not finite"
        raise ExpressionError(msg)

    def like(self, value: float) -> "Quantity":
        """Another value of the same dimension."""
        return Quantity(value, *self.dimension)

    def __neg__(self) -> "Quantity":
        return self.like(-self.value)

    def combined(self, sign: str, other: "Quantity") -> "Quantity | bool":
        """`self sign other`; ExpressionError where the dimensions do not allow it."""
        if sign == "*":
            product = self.value * other.value
            return Quantity(product, self.length + other.length, self.angle + other.angle).checked()
        if sign == "/":
            if other.value == 0.0:
                msg = "a division by zero"
                raise ExpressionError(msg)
            ratio = self.value / other.value
            return Quantity(ratio, self.length - other.length, self.angle - other.angle).checked()
        if sign == "^":
            return self.power(other)
        self.same(other, repr(sign))
        a, b = self.value, other.value
        match sign:
            case "+":
                return self.like(a + b).checked()
            case "-":
                return self.like(a - b).checked()
            case "%":
                return self.modulo(other)
        return {"==": a == b, "!=": a != b, "<": a < b, ">": a > b, "<=": a <= b, ">=": a >= b}[sign]

    def modulo(self, other: "Quantity") -> "Quantity":
        """The remainder of a division by `other`, with the sign of `other`."""
        if other.value == 0.0:
            msg = "a division by zero"
            raise ExpressionError(msg)
        return self.like(self.value % other.value).checked()

    def power(self, exponent: "Quantity") -> "Quantity":
        """To the power of a plain number."""
        if exponent.dimension != NONE:
            msg = f"an exponent must be a number, not {exponent.what}"
            raise ExpressionError(msg)
        power = exponent.value
        try:
            value = self.value**power
        except (OverflowError, ZeroDivisionError):
            value = math.inf
        if isinstance(value, complex):
            msg = "a negative number to a fractional power"
            raise ExpressionError(msg)
        result = Quantity(float(value)).checked()
        if self.dimension == NONE:
            return result
        if abs(power) > _MOST_POWER:
            msg = f"a power above {_MOST_POWER} of a quantity with a unit"
            raise ExpressionError(msg)
        share = Fraction(power).limit_denominator(12)
        return Quantity(result.value, self.length * share, self.angle * share)

    def same(self, other: "Quantity", where: str) -> None:
        """ExpressionError unless both have the same dimension."""
        if self.dimension != other.dimension:
            msg = f"{where} needs two values of the same dimension, not {self.what} and {other.what}"
            raise ExpressionError(msg)


Value = Quantity | bool


def unit(size: float, measure: Measure) -> Quantity:
    """A length of `size` metres, or an angle of `size` radians."""
    return Quantity(size, *(LENGTH if measure == "length" else ANGLE))


def truth(value: Value) -> bool:
    """A condition; ExpressionError for a quantity."""
    if isinstance(value, bool):
        return value
    msg = f"a condition must be true or false, not {value.what}"
    raise ExpressionError(msg)
