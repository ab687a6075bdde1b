"""Evaluates expressions as designers type them: numbers with units, variables, functions.

`-#reach / 2 + 15 deg` is evaluated in SI with its dimension, so that a length in place of an angle
is detected. Angles are a dimension of their own. The language is what Onshape's fields accept
of FeatureScript: arithmetic, comparison, `cond ? a : b`, and the functions of its math library.
"""

from collections.abc import Callable, Mapping, Sequence

from linkwright.stages.graph.onshape.expressions.functions import CONSTANTS, FUNCTIONS
from linkwright.stages.graph.onshape.expressions.quantity import (
    DIMENSIONLESS,
    ExpressionError,
    Quantity,
    UnknownVariable,
    Value,
    truth,
    unit,
)
from linkwright.stages.graph.onshape.expressions.syntax import MAX_DEPTH, Expression, parse
from linkwright.stages.robot.text.units import UNITS, Measure

__all__ = ["ExpressionError", "Quantity", "Scope", "UnknownVariable", "Value", "evaluate", "measured"]

Lookup = Callable[[str], Value]


class Scope:
    """Variables by name, each of which is evaluated when it is first needed.

    `expressions`: name → its expression. `values`: name → its value as text ("30 deg"); it is used if the
    expression cannot be evaluated, and `rounded` collects the names of these variables.
    """

    def __init__(self, expressions: Mapping[str, str], values: Mapping[str, str] | None = None) -> None:
        self._expressions = expressions
        self._texts = values or {}
        self._known: dict[str, Value] = {}
        self._open: list[str] = []
        self._inexact: set[str] = set()
        self._uses = 0
        self.rounded: set[str] = set()

    def __call__(self, name: str) -> Value:
        """Returns the value of a variable; raises ExpressionError if it has none."""
        if name in self._known:
            self._note(name)
            return self._known[name]
        if name not in self._expressions:
            raise UnknownVariable(name)
        if name in self._open:
            circle = " → ".join(f"#{variable}" for variable in (*self._open[self._open.index(name) :], name))
            msg = f"variables refer to each other in a cycle: {circle}"
            raise ExpressionError(msg)
        if len(self._open) >= MAX_DEPTH:
            msg = f"variables are nested more than {MAX_DEPTH} deep"
            raise ExpressionError(msg)
        self._open.append(name)
        uses = self._uses
        try:
            self._known[name] = self._value(name)
        finally:
            self._open.pop()
        if self._uses > uses:
            self._inexact.add(name)
        return self._known[name]

    def _note(self, name: str) -> None:
        """Records the use of a rounded variable."""
        if name in self._inexact:
            self._uses += 1
            self.rounded.add(name)

    def _value(self, name: str) -> Value:
        try:
            return evaluate(self._expressions[name], self)
        except ExpressionError as error:
            if self._texts.get(name):
                try:
                    value = evaluate(self._texts[name], self)
                except ExpressionError:
                    pass
                else:
                    self._inexact.add(name)
                    self._note(name)
                    return value
            if isinstance(error, UnknownVariable):
                raise
            msg = f"#{name} = {self._expressions[name]!r}: {error}"
            raise ExpressionError(msg) from None


def evaluate(text: str, lookup: Lookup) -> Value:
    """Returns the value of an expression; `lookup` gives variables. Raises ExpressionError for an invalid
    expression."""
    try:
        return _value_of(parse(text), lookup)
    except RecursionError:
        msg = "it is nested too deep"
        raise ExpressionError(msg) from None


def measured(text: str, measure: Measure, lookup: Lookup) -> float:
    """Returns the value of an expression that must be a length [m] or an angle [rad]; raises
    ExpressionError if it is not.

    A 0 without a unit is both a length and an angle; any other number needs its unit.
    """
    value = evaluate(text, lookup)
    expected = unit(0.0, measure)
    if isinstance(value, Quantity):
        if value.dimension == expected.dimension:
            return value.value
        if value.dimension == DIMENSIONLESS and value.value == 0.0:
            return 0.0
        actual = value.description
    else:
        actual = "true or false"
    msg = f"expected {expected.description}, got {actual}"
    raise ExpressionError(msg)


def _value_of(node: Expression, lookup: Lookup) -> Value:
    match node.kind:
        case "number":
            return Quantity(float(node.name)).checked()
        case "variable":
            return lookup(node.name)
        case "name":
            return _constant(node.name)
        case "call":
            return _call_value(node.name, [_value_of(operand, lookup) for operand in node.operands])
        case "unary":
            return _unary(node.name, _value_of(node.operands[0], lookup))
        case "choice":
            condition, value_if_true, value_if_false = node.operands
            return _value_of(value_if_true if truth(_value_of(condition, lookup)) else value_if_false, lookup)
        case "binary":
            first, second = node.operands
            return _binary(node.name, first, second, lookup)


def _constant(name: str) -> Value:
    if name in UNITS:
        size, measure = UNITS[name]
        return unit(size, measure)
    if name in CONSTANTS:
        return CONSTANTS[name]
    msg = f"{name!r} is no unit" + (" (a function needs its parentheses)" if name in FUNCTIONS else "")
    raise ExpressionError(msg)


def _call_value(name: str, values: Sequence[Value]) -> Value:
    if name not in FUNCTIONS:
        msg = f"the function {name}() is not known"
        raise ExpressionError(msg)
    min_count, max_count, function = FUNCTIONS[name]
    if not min_count <= len(values) <= max_count:
        count = str(min_count) if min_count == max_count else f"{min_count} or more"
        msg = f"{name}() takes {count} values and got {len(values)}"
        raise ExpressionError(msg)
    quantities = []
    for value in values:
        if not isinstance(value, Quantity):
            msg = f"{name}() takes quantities, not true or false"
            raise ExpressionError(msg)
        quantities.append(value)
    return function(quantities).checked()


def _unary(sign: str, value: Value) -> Value:
    if sign == "!":
        return not truth(value)
    if not isinstance(value, Quantity):
        msg = f"{sign!r} takes a quantity, not true or false"
        raise ExpressionError(msg)
    return -value if sign == "-" else value


def _binary(sign: str, first: Expression, second: Expression, lookup: Lookup) -> Value:
    if sign in ("&&", "||"):
        left_value = truth(_value_of(first, lookup))
        return left_value if left_value == (sign == "||") else truth(_value_of(second, lookup))
    a, b = _value_of(first, lookup), _value_of(second, lookup)
    if sign in ("==", "!=") and isinstance(a, bool) and isinstance(b, bool):
        return (a == b) == (sign == "==")
    if not isinstance(a, Quantity) or not isinstance(b, Quantity):
        msg = f"{sign!r} takes quantities, not true or false"
        raise ExpressionError(msg)
    return a.apply_operator(sign, b)
