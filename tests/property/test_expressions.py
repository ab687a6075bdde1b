"""Random expressions against a direct evaluation of the same tree."""

import math
from dataclasses import dataclass

from hypothesis import given
from hypothesis import strategies as st

from linkwright.stages.graph.onshape.expressions.evaluate import ExpressionError, Scope, evaluate
from linkwright.stages.graph.onshape.expressions.quantity import Quantity

UNITS = {
    "mm": (1e-3, (1, 0)), "in": (0.0254, (1, 0)), "meter": (1.0, (1, 0)), "deg": (math.pi / 180, (0, 1)),
    "rad": (1.0, (0, 1)), "revolution": (2 * math.pi, (0, 1)),
}  # fmt: skip
VARIABLES = {
    "len": ("3 mm", 3e-3, (1, 0)),
    "turn": ("20 deg", 20 * math.pi / 180, (0, 1)),
    "n": ("7", 7.0, (0, 0)),
}
SUM, PRODUCT, UNIT, POWER, LEAF = range(5)


@dataclass(frozen=True)
class Drawn:
    """An expression's text, how tightly its outermost operator binds, and what it must come to."""

    text: str
    binds: int
    value: float
    dimension: tuple


def inside(operand, least):
    """The text as an operand that must bind at least as tightly as `least`."""
    return operand.text if operand.binds >= least else f"({operand.text})"


@st.composite
def leaves(draw):
    kind = draw(st.sampled_from(["number", "unit", "variable"]))
    if kind == "variable":
        name = draw(st.sampled_from(sorted(VARIABLES)))
        return Drawn(f"#{name}", LEAF, *VARIABLES[name][1:])
    number = draw(st.integers(0, 999)) / draw(st.sampled_from([1, 10, 100]))
    if kind == "number":
        return Drawn(repr(number), LEAF, number, (0, 0))
    unit = draw(st.sampled_from(sorted(UNITS)))
    size, dimension = UNITS[unit]
    space = draw(st.sampled_from(["", " ", "*", " * "]))
    return Drawn(f"{number!r}{space}{unit}", PRODUCT if "*" in space else UNIT, number * size, dimension)


def same_kind(first, other):
    """`other` made the dimension of `one`, by as many units."""
    length, angle = (a - b for a, b in zip(first.dimension, other.dimension, strict=True))
    text = f"{inside(other, PRODUCT)} * meter^{length} * rad^{angle}"
    return Drawn(text, PRODUCT, other.value, first.dimension)


@st.composite
def combined(draw, children):
    first, other = draw(children), draw(children)
    operation = draw(st.sampled_from(["+", "-", "*", "/", "^", "neg", "min", "max", "abs", "trig", "if"]))
    space = draw(st.sampled_from(["", " "]))
    if operation == "neg":
        # Between sum and product, but never beside another sign.
        return Drawn(f"(-{inside(first, POWER)})", LEAF, -first.value, first.dimension)
    if operation == "abs":
        return Drawn(f"abs({first.text})", LEAF, abs(first.value), first.dimension)
    if operation == "trig":
        length, angle = first.dimension
        name = draw(st.sampled_from(["sin", "cos"]))
        text = f"{name}({inside(first, PRODUCT)} * meter^{-length} * rad^{1 - angle})"
        return Drawn(text, LEAF, getattr(math, name)(first.value), (0, 0))
    if operation == "^":
        power = draw(st.integers(0, 2))
        dimension = tuple(power * exponent for exponent in first.dimension)
        return Drawn(f"{inside(first, LEAF)}^{power}", POWER, first.value**power, dimension)
    if operation in "*/":
        sign = 1 if operation == "*" else -1
        if sign < 0 and other.value == 0:
            other = Drawn("1", LEAF, 1.0, (0, 0))
        value = first.value * other.value if sign > 0 else first.value / other.value
        dimension = tuple(a + sign * b for a, b in zip(first.dimension, other.dimension, strict=True))
        left = inside(first, PRODUCT)
        # A number before the stroke would make a fraction of it: 1/2 in.
        right = inside(other, POWER if left[-1].isdigit() else UNIT)
        return Drawn(f"{left}{space}{operation}{space}{right}", PRODUCT, value, dimension)
    other = same_kind(first, other)
    if operation in "+-":
        value = first.value + other.value if operation == "+" else first.value - other.value
        text = f"{inside(first, SUM)}{space}{operation}{space}{inside(other, PRODUCT)}"
        return Drawn(text, SUM, value, first.dimension)
    if operation == "if":
        value = first.value if first.value < other.value else other.value
        return Drawn(
            f"({first.text} < {other.text} ? {first.text} : {other.text})", LEAF, value, first.dimension
        )
    pick = {"min": min, "max": max}[operation]
    text = f"{operation}({first.text},{space}{other.text})"
    return Drawn(text, LEAF, pick(first.value, other.value), first.dimension)


EXPRESSIONS = st.recursive(leaves(), combined, max_leaves=8)
SCOPE = Scope({name: text for name, (text, _, _) in VARIABLES.items()})


def outcome(text):
    """The value of an expression, or why it has none."""
    try:
        return evaluate(text, SCOPE), ""
    except ExpressionError as error:
        return None, str(error)


@given(EXPRESSIONS)
def test_an_expression_comes_to_what_its_tree_comes_to(drawn):
    value, why = outcome(drawn.text)
    if value is None:
        # Bounds of what is evaluated; the tree knows none.
        assert any(bound in why for bound in ("deep", "pieces", "above 64")), (drawn.text, why)
        return
    assert isinstance(value, Quantity)
    assert value.dimension == drawn.dimension
    assert math.isclose(value.value, drawn.value, rel_tol=1e-9, abs_tol=1e-9)


@given(st.text(alphabet="#ab1. ()+-*/^%?:<>=!&|,degmsin\n\"'é", max_size=60))
def test_any_text_has_a_value_or_an_error_that_says_why(text):
    value, why = outcome(text)
    assert why or isinstance(value, bool) or math.isfinite(value.value)
