"""Expressions as designers type them: numbers with units, variables, functions.

`-#reach / 2 + 15 deg` is evaluated in SI with its dimension, so that a length where an angle is
expected is found. Angles are a dimension of their own. The language is what Onshape's fields accept
of FeatureScript: arithmetic, comparison, `cond ? a : b`, and the functions of its math library.
"""

from collections.abc import Callable, Mapping, Sequence

from linkwright.stages.graph.onshape.expressions.functions import CONSTANTS, FUNCTIONS
from linkwright.stages.graph.onshape.expressions.quantity import (
    NONE,
    ExpressionError,
    Quantity,
    UnknownVariable,
    Value,
    truth,
    unit,
)
from linkwright.stages.graph.onshape.expressions.syntax import DEEPEST, Expression, parse
from linkwright.stages.robot.text.units import UNITS, Measure

__all__ = ["ExpressionError", "Quantity", "Scope", "UnknownVariable", "Value", "evaluate", "measured"]

Lookup = Callable[[str], Value]


class Scope:
    """Variables by name, each evaluated when it is first asked for.

    `expressions`: name → its expression; `values`: name → its value as text ("30 deg"), which
    is used where the expression cannot be evaluated. `rounded` collects the names of such variables.
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
        """The variable's value; ExpressionError where it has none."""
        if name in self._known:
            self._note(name)
            return self._known[name]
        if name not in self._expressions:
            raise UnknownVariable(name)
        if name in self._open:
            circle = " → ".join(f"#{one}" for one in (*self._open[self._open.index(name) :], name))
            msg = f"variables refer to each other in a circle: {circle}"
            raise ExpressionError(msg)
        if len(self._open) >= DEEPEST:
            msg = f"variables are nested more than {DEEPEST} deep"
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
    """The value of an expression; `lookup` gives variables. ExpressionError for an invalid expression."""
    try:
        return _evaluated(parse(text), lookup)
    except RecursionError:
        msg = "it is nested too deep"
        raise ExpressionError(msg) from None


def measured(text: str, measure: Measure, lookup: Lookup) -> float:
    """An expression that must be a length [m] or an angle [rad]; ExpressionError where it is not.

    A bare 0 is both; any other number needs its unit.
    """
    value = evaluate(text, lookup)
    wanted = unit(0.0, measure)
    if isinstance(value, Quantity):
        if value.dimension == wanted.dimension:
            return value.value
        if value.dimension == NONE and value.value == 0.0:
            return 0.0
        what = value.what
    else:
        what = "true or false"
    msg = f"expected {wanted.what}, got {what}"
    raise ExpressionError(msg)


def _evaluated(node: Expression, lookup: Lookup) -> Value:
    match node.kind:
        case "number":
            return Quantity(float(node.name)).checked()
        case "variable":
            return lookup(node.name)
        case "name":
            return _named(node.name)
        case "call":
            return _called(node.name, [_evaluated(one, lookup) for one in node.below])
        case "unary":
            return _unary(node.name, _evaluated(node.below[0], lookup))
        case "choice":
            condition, then, other = node.below
            return _evaluated(then if truth(_evaluated(condition, lookup)) else other, lookup)
        case "binary":
            first, second = node.below
            return _binary(node.name, first, second, lookup)


def _named(name: str) -> Value:
    if name in UNITS:
        size, measure = UNITS[name]
        return unit(size, measure)
    if name in CONSTANTS:
        return CONSTANTS[name]
    msg = f"{name!r} is no unit" + (" (a function needs its parentheses)" if name in FUNCTIONS else "")
    raise ExpressionError(msg)


def _called(name: str, values: Sequence[Value]) -> Value:
    if name not in FUNCTIONS:
        msg = f"the function {name}() is not known"
        raise ExpressionError(msg)
    least, most, function = FUNCTIONS[name]
    if not least <= len(values) <= most:
        count = str(least) if least == most else f"{least} or more"
        msg = f"{name}() takes {count} values and got {len(values)}"
        raise ExpressionError(msg)
    plain = []
    for value in values:
        if not isinstance(value, Quantity):
            msg = f"{name}() takes quantities, not true or false"
            raise ExpressionError(msg)
        plain.append(value)
    return function(plain).checked()


def _unary(sign: str, value: Value) -> Value:
    if sign == "!":
        return not truth(value)
    if not isinstance(value, Quantity):
        msg = f"{sign!r} takes a quantity, not true or false"
        raise ExpressionError(msg)
    return -value if sign == "-" else value


def _binary(sign: str, first: Expression, second: Expression, lookup: Lookup) -> Value:
    if sign in ("&&", "||"):
        left = truth(_evaluated(first, lookup))
        return left if left == (sign == "||") else truth(_evaluated(second, lookup))
    a, b = _evaluated(first, lookup), _evaluated(second, lookup)
    if sign in ("==", "!=") and isinstance(a, bool) and isinstance(b, bool):
        return (a == b) == (sign == "==")
    if not isinstance(a, Quantity) or not isinstance(b, Quantity):
        msg = f"{sign!r} takes quantities, not true or false"
        raise ExpressionError(msg)
    return a.combined(sign, b)
