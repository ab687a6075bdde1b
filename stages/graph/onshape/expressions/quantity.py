"""Computes with numbers that have a dimension."""

import math
from dataclasses import dataclass
from fractions import Fraction

from linkwright.stages.robot.text.units import Measure

Dimension = tuple[Fraction, Fraction]
"""Exponents of metre and radian."""

DIMENSIONLESS: Dimension = (Fraction(0), Fraction(0))
LENGTH: Dimension = (Fraction(1), Fraction(0))
ANGLE: Dimension = (Fraction(0), Fraction(1))

_NAMES = {
    DIMENSIONLESS: "a number",
    LENGTH: "a length",
    ANGLE: "an angle",
    (Fraction(2), Fraction(0)): "an area",
}
_MAX_POWER = 64


class ExpressionError(Exception):
    """An error for an expression without a value; its text is the reason, and is written after a colon."""


class UnknownVariable(ExpressionError):
    """An error for a variable that is not defined."""

    def __init__(self, name: str) -> None:
        super().__init__(f"the variable #{name} is not known")
        self.name = name


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number with its dimension."""

    value: float
    """Value in SI units."""
    length: Fraction = Fraction(0)
    """Exponent of metre."""
    angle: Fraction = Fraction(0)
    """Exponent of radian."""

    @property
    def dimension(self) -> Dimension:
        """The exponents of metre and radian."""
        return self.length, self.angle

    @property
    def description(self) -> str:
        """The dimension in words."""
        return _NAMES.get(self.dimension, f"a quantity in m^({self.length})·rad^({self.angle})")

    def checked(self) -> "Quantity":
        """Returns this quantity; raises ExpressionError if its value is not finite."""
        if math.isfinite(self.value):
            return self
        msg = "a value is not finite"
        raise ExpressionError(msg)

    def like(self, value: float) -> "Quantity":
        """Returns another value of the same dimension."""
        return Quantity(value, *self.dimension)

    def __neg__(self) -> "Quantity":
        return self.like(-self.value)

    def apply_operator(self, sign: str, other: "Quantity") -> "Quantity | bool":
        """Returns `self sign other`; raises ExpressionError if the dimensions do not allow it."""
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
        self.require_same_dimension(other, repr(sign))
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
        """Returns the remainder of a division by `other`, with the sign of `other`."""
        if other.value == 0.0:
            msg = "a division by zero"
            raise ExpressionError(msg)
        return self.like(self.value % other.value).checked()

    def power(self, exponent: "Quantity") -> "Quantity":
        """Returns the quantity to the power of a plain number."""
        if exponent.dimension != DIMENSIONLESS:
            msg = f"an exponent must be a number, not {exponent.description}"
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
        if self.dimension == DIMENSIONLESS:
            return result
        if abs(power) > _MAX_POWER:
            msg = f"a power above {_MAX_POWER} of a quantity with a unit"
            raise ExpressionError(msg)
        exponent_fraction = Fraction(power).limit_denominator(12)
        return Quantity(result.value, self.length * exponent_fraction, self.angle * exponent_fraction)

    def require_same_dimension(self, other: "Quantity", where: str) -> None:
        """Raises ExpressionError unless both have the same dimension."""
        if self.dimension != other.dimension:
            dimensions = f"{self.description} and {other.description}"
            msg = f"{where} needs two values of the same dimension, not {dimensions}"
            raise ExpressionError(msg)


Value = Quantity | bool


def unit(size: float, measure: Measure) -> Quantity:
    """Returns a length of `size` metres, or an angle of `size` radians."""
    return Quantity(size, *(LENGTH if measure == "length" else ANGLE))


def truth(value: Value) -> bool:
    """Returns the value of a condition; raises ExpressionError for a quantity."""
    if isinstance(value, bool):
        return value
    msg = f"a condition must be true or false, not {value.description}"
    raise ExpressionError(msg)
