"""Parses expressions to trees, by precedence climbing.

Precedence from loose to tight: `? :`, `||`, `&&`, equality, order, `+ -`, `* / %`, a unit after a
value, unary signs, `^` (which groups to the right). So `6 mm / 3 mm` is 2; but numbers and constants
that are multiplied or divided before a unit are one number, as on paper: `1/2 in` is half an inch,
`PI/2 rad` a right angle. So are a whole number and a fraction (`1 1/2 in`), and values that follow each
other in ever smaller units are one value (`1 ft 2 in`, `1' 2 1/2"`). Length and depth are bounded, since
the text comes from a document that anyone may have written.
"""

import math
import re
from dataclasses import dataclass
from typing import Literal

from linkwright.stages.graph.onshape.expressions.quantity import ExpressionError
from linkwright.stages.robot.text.units import UNITS

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
    r"|(?P<variable>#[A-Za-z_]\w*)"
    r"|(?P<name>[A-Za-z_]\w*|µm|[°'\"′″])"
    r"|(?P<sign>&&|\|\||==|!=|<=|>=|[-+*/%^()<>?:,!]))"
)
_MAX_TOKENS = 400
MAX_DEPTH = 60
_BINARY = {"||": 2, "&&": 3, "==": 4, "!=": 4, "<": 5, ">": 5, "<=": 5, ">=": 5}
_BINARY |= {"+": 6, "-": 6, "*": 7, "/": 7, "%": 7, "^": 10}
_TERNARY, _UNIT, _UNARY = 1, 8, 9
_CONSTANT = "PI"


@dataclass(frozen=True, slots=True)
class Expression:
    """A node of the tree of an expression."""

    kind: Literal["number", "variable", "name", "call", "unary", "binary", "choice"]
    """Kind of the node, by which `name` is a number, a variable, a unit or constant, a function or a sign."""
    name: str
    operands: tuple["Expression", ...] = ()
    """The operands."""


def parse(text: str) -> Expression:
    """Parses a text to the tree of its expression; raises ExpressionError for an invalid text."""
    return _Parser(text).whole()


class _Parser:
    """Precedence climbing over the tokens of an expression."""

    def __init__(self, text: str) -> None:
        self._tokens = _tokens(text)
        self._position = 0
        self._depth = 0

    def whole(self) -> Expression:
        """Parses the whole text; raises ExpressionError for an invalid text."""
        node = self._expression(0)
        kind, token = self._peek()
        if kind:
            msg = f"{token!r} is not expected there"
            raise ExpressionError(msg)
        return node

    def _expression(self, min_precedence: int, *, exponent: bool = False) -> Expression:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            msg = f"it is nested more than {MAX_DEPTH} deep"
            raise ExpressionError(msg)
        operand = self._operand(exponent=exponent)
        while True:
            kind, token = self._peek()
            if kind == "name" and token in UNITS and min_precedence <= _UNIT:
                # A unit binds its own power first: 5 mm^2 is 5·(mm²).
                operand = Expression("binary", "*", (operand, self._expression(_UNIT + 1)))
            elif kind == "sign" and token in _BINARY and _BINARY[token] >= min_precedence:
                self._position += 1
                power = _BINARY[token]
                # `^` groups to the right and takes a sign: 2^-1, 2^3^2.
                right = self._expression(_UNARY if token == "^" else power + 1, exponent=token == "^")
                operand = Expression("binary", token, (operand, right))
            elif kind == "sign" and token == "?" and min_precedence <= _TERNARY:
                self._position += 1
                value_if_true = self._expression(_TERNARY)
                self._expect(":")
                operand = Expression("choice", "?", (operand, value_if_true, self._expression(_TERNARY)))
            else:
                self._depth -= 1
                return operand

    def _operand(self, *, exponent: bool) -> Expression:
        kind, token = self._peek()
        self._position += 1
        if kind == "number":
            return Expression("number", token) if exponent else self._literal(token)
        if token == _CONSTANT and not exponent:
            return self._before_unit(Expression("name", token))
        if kind == "variable":
            return Expression("variable", token[1:])
        if kind == "name":
            if self._peek()[1] == "(":
                self._position += 1
                return Expression("call", token, self._arguments())
            return Expression("name", token)
        if kind == "sign" and token in "-+!":
            return Expression("unary", token, (self._expression(_UNARY),))
        if token == "(":
            inner = self._expression(0)
            self._expect(")")
            return inner
        msg = f"{token!r} is not expected there" if kind else "it is incomplete"
        raise ExpressionError(msg)

    def _literal(self, number: str) -> Expression:
        """Reads a number as on paper: with a fraction, with factors or divisors before a unit, or with
        values in smaller units after its own."""
        value = self._mixed(number)
        if self._peek()[1] not in UNITS or self._peek(1)[0] != "number":
            return self._before_unit(value)
        unit_size = math.inf
        total: Expression | None = None
        while self._peek()[1] in UNITS:
            unit = self._peek()[1]
            if UNITS[unit][0] >= unit_size:
                msg = f"{unit!r} is not expected there: it is no smaller than the unit before it"
                raise ExpressionError(msg)
            self._position += 1
            unit_size = UNITS[unit][0]
            part = Expression("binary", "*", (value, Expression("name", unit)))
            total = part if total is None else Expression("binary", "+", (total, part))
            kind, token = self._peek()
            if kind != "number":
                return total
            self._position += 1
            value = self._mixed(token)
        msg = "a number without a unit follows a number with a unit"
        raise ExpressionError(msg)

    def _mixed(self, number: str) -> Expression:
        """Reads a whole number with a fraction after it, `1 1/2`, as their sum; else the number itself."""
        numerator, slash, denominator = (self._peek(ahead) for ahead in range(3))
        is_fraction = number.isdigit() and numerator[1].isdigit() and denominator[1].isdigit()
        if not (is_fraction and slash[1] == "/"):
            return Expression("number", number)
        self._position += 3
        fraction = Expression(
            "binary", "/", (Expression("number", numerator[1]), Expression("number", denominator[1]))
        )
        return Expression("binary", "+", (Expression("number", number), fraction))

    def _before_unit(self, value: Expression) -> Expression:
        """Reads the factors and divisors after a number or constant, if a unit follows them; otherwise
        returns the value itself."""
        ahead = 0
        while self._peek(ahead)[1] in ("*", "/") and self._is_plain(self._peek(ahead + 1)):
            ahead += 2
        has_second_unit = self._peek(ahead + 1)[0] == "number"  # 2 * 1 ft 2 in
        if ahead == 0 or has_second_unit or self._peek(ahead)[1] not in UNITS:
            return value
        for _ in range(0, ahead, 2):
            (_, sign), (kind, token) = self._peek(), self._peek(1)
            self._position += 2
            value = Expression(
                "binary", sign, (value, Expression("number" if kind == "number" else "name", token))
            )
        return value

    def _is_plain(self, token: tuple[str, str]) -> bool:
        return token[0] == "number" or token[1] == _CONSTANT

    def _arguments(self) -> tuple[Expression, ...]:
        if self._peek()[1] == ")":
            self._position += 1
            return ()
        arguments = [self._expression(0)]
        while self._peek()[1] == ",":
            self._position += 1
            arguments.append(self._expression(0))
        self._expect(")")
        return tuple(arguments)

    def _expect(self, sign: str) -> None:
        kind, token = self._peek()
        if token != sign:
            msg = f"{sign!r} is expected" + (f" in place of {token!r}" if kind else " at the end")
            raise ExpressionError(msg)
        self._position += 1

    def _peek(self, ahead: int = 0) -> tuple[str, str]:
        token_index = self._position + ahead
        return self._tokens[token_index] if token_index < len(self._tokens) else ("", "")


def _tokens(text: str) -> list[tuple[str, str]]:
    tokens = []
    position, end = 0, len(text.rstrip())
    while position < end:
        match = _TOKEN.match(text, position)
        if match is None:
            msg = f"{text[position:].strip()[:1]!r} is not understood"
            raise ExpressionError(msg)
        kind = match.lastgroup or ""
        tokens.append((kind, match[kind]))
        if len(tokens) > _MAX_TOKENS:
            msg = f"it has more than {_MAX_TOKENS} tokens"
            raise ExpressionError(msg)
        position = match.end()
    return tokens
