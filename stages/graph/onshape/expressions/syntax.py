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
from typing import Literal, NamedTuple

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
"""Largest depth of nesting, of an expression and of the variables that it refers to."""

_BINARY_PRECEDENCE = {"||": 2, "&&": 3, "==": 4, "!=": 4, "<": 5, ">": 5, "<=": 5, ">=": 5}
_BINARY_PRECEDENCE |= {"+": 6, "-": 6, "*": 7, "/": 7, "%": 7, "^": 10}
_CHOICE_PRECEDENCE, _UNIT_PRECEDENCE, _UNARY_PRECEDENCE = 1, 8, 9
"""The higher its precedence, the tighter a sign binds."""

_CONSTANT = "PI"


@dataclass(frozen=True, slots=True)
class Expression:
    """A node of the tree of an expression."""

    kind: Literal["number", "variable", "name", "call", "unary", "binary", "choice"]
    """Kind of the node."""
    name: str
    """A number, a variable, a unit or constant (of the kind "name"), a function ("call") or a sign (of the
    last three kinds)."""
    operands: tuple["Expression", ...] = ()
    """Operands of a sign, or arguments of a function, from left to right."""


def parse(text: str) -> Expression:
    """Parses a text to the tree of its expression; raises ExpressionError for an invalid text."""
    return _Parser(text).parse_whole()


class _Token(NamedTuple):
    """A token; `kind`: the group of `_TOKEN` that matched, "" after the last token."""

    kind: str
    text: str


class _Parser:
    """Precedence climbing over the tokens of an expression."""

    def __init__(self, text: str) -> None:
        self._tokens = _tokens(text)
        self._position = 0
        self._depth = 0

    def parse_whole(self) -> Expression:
        """Parses the whole text; raises ExpressionError for an invalid text."""
        node = self._expression(0)
        kind, token = self._peek()
        if kind:
            msg = f"{token!r} is not expected there"
            raise ExpressionError(msg)
        return node

    def _expression(self, min_precedence: int, *, exponent: bool = False) -> Expression:
        """Parses operands and signs of at least `min_precedence`. `exponent`: whether the first operand is an
        exponent, whose number takes no fraction, factors or unit."""
        self._depth += 1
        if self._depth > MAX_DEPTH:
            msg = f"it is nested more than {MAX_DEPTH} deep"
            raise ExpressionError(msg)
        operand = self._operand(exponent=exponent)
        while True:
            kind, token = self._peek()
            if kind == "name" and token in UNITS and min_precedence <= _UNIT_PRECEDENCE:
                # A unit binds its own power first: 5 mm^2 is 5·(mm²).
                operand = Expression("binary", "*", (operand, self._expression(_UNIT_PRECEDENCE + 1)))
            elif kind == "sign" and _BINARY_PRECEDENCE.get(token, -1) >= min_precedence:
                self._position += 1
                # `^` groups to the right and takes a sign: 2^-1, 2^3^2.
                is_power = token == "^"
                right_precedence = _UNARY_PRECEDENCE if is_power else _BINARY_PRECEDENCE[token] + 1
                right = self._expression(right_precedence, exponent=is_power)
                operand = Expression("binary", token, (operand, right))
            elif kind == "sign" and token == "?" and min_precedence <= _CHOICE_PRECEDENCE:
                self._position += 1
                value_if_true = self._expression(_CHOICE_PRECEDENCE)
                self._expect(":")
                value_if_false = self._expression(_CHOICE_PRECEDENCE)
                operand = Expression("choice", "?", (operand, value_if_true, value_if_false))
            else:
                self._depth -= 1
                return operand

    def _operand(self, *, exponent: bool) -> Expression:
        kind, token = self._peek()
        self._position += 1
        if kind == "number":
            return Expression("number", token) if exponent else self._number(token)
        if token == _CONSTANT and not exponent:
            return self._with_factors_before_unit(Expression("name", token))
        if kind == "variable":
            return Expression("variable", token[1:])
        if kind == "name":
            if self._peek().text == "(":
                self._position += 1
                return Expression("call", token, self._arguments())
            return Expression("name", token)
        if kind == "sign" and token in "-+!":
            return Expression("unary", token, (self._expression(_UNARY_PRECEDENCE),))
        if token == "(":
            inner = self._expression(0)
            self._expect(")")
            return inner
        msg = f"{token!r} is not expected there" if kind else "it is incomplete"
        raise ExpressionError(msg)

    def _number(self, number: str) -> Expression:
        """Reads a number as on paper: with a fraction, with factors or divisors before a unit, or with
        values in smaller units after its own."""
        value = self._mixed_number(number)
        if self._peek().text not in UNITS or self._peek(1).kind != "number":
            return self._with_factors_before_unit(value)
        unit_size = math.inf
        total: Expression | None = None
        while self._peek().text in UNITS:
            unit = self._peek().text
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
            value = self._mixed_number(token)
        msg = "a number without a unit follows a number with a unit"
        raise ExpressionError(msg)

    def _mixed_number(self, number: str) -> Expression:
        """Reads a whole number with a fraction after it, `1 1/2`, as their sum; else the number itself."""
        numerator, slash, denominator = (self._peek(ahead) for ahead in range(3))
        is_fraction = number.isdigit() and numerator.text.isdigit() and denominator.text.isdigit()
        if not (is_fraction and slash.text == "/"):
            return Expression("number", number)
        self._position += 3
        fraction = Expression(
            "binary", "/", (Expression("number", numerator.text), Expression("number", denominator.text))
        )
        return Expression("binary", "+", (Expression("number", number), fraction))

    def _with_factors_before_unit(self, value: Expression) -> Expression:
        """Reads the factors and divisors after a number or constant, if a unit follows them; otherwise
        returns the value itself."""
        ahead = 0
        while self._peek(ahead).text in ("*", "/") and _is_number_or_constant(self._peek(ahead + 1)):
            ahead += 2
        has_second_unit = self._peek(ahead + 1).kind == "number"  # 2 * 1 ft 2 in
        if ahead == 0 or has_second_unit or self._peek(ahead).text not in UNITS:
            return value
        for _ in range(0, ahead, 2):
            (_, sign), (kind, token) = self._peek(), self._peek(1)
            self._position += 2
            value = Expression(
                "binary", sign, (value, Expression("number" if kind == "number" else "name", token))
            )
        return value

    def _arguments(self) -> tuple[Expression, ...]:
        if self._peek().text == ")":
            self._position += 1
            return ()
        arguments = [self._expression(0)]
        while self._peek().text == ",":
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

    def _peek(self, ahead: int = 0) -> _Token:
        token_index = self._position + ahead
        return self._tokens[token_index] if token_index < len(self._tokens) else _Token("", "")


def _is_number_or_constant(token: _Token) -> bool:
    return token.kind == "number" or token.text == _CONSTANT


def _tokens(text: str) -> list[_Token]:
    tokens = []
    position, end = 0, len(text.rstrip())
    while position < end:
        match = _TOKEN.match(text, position)
        if match is None:
            msg = f"{text[position:].strip()[:1]!r} is not understood"
            raise ExpressionError(msg)
        kind = match.lastgroup or ""
        tokens.append(_Token(kind, match[kind]))
        if len(tokens) > _MAX_TOKENS:
            msg = f"it has more than {_MAX_TOKENS} tokens"
            raise ExpressionError(msg)
        position = match.end()
    return tokens
