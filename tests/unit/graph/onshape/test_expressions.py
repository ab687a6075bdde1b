"""Expressions as designers type them, in SI and with their dimension."""

import math

import pytest

from linkwright.stages.graph.onshape.expressions.evaluate import (
    ExpressionError,
    Scope,
    UnknownVariable,
    evaluate,
    measured,
)

DEGREE = math.pi / 180
SCOPE = Scope({"reach": "30 deg", "twice": "#reach * 2", "wide": "1/2 in", "flag": "#reach > 1 rad"})


def angle(text):
    return measured(text, "angle", SCOPE)


def length(text):
    return measured(text, "length", SCOPE)


@pytest.mark.parametrize(
    ("text", "degrees"),
    [
        ("60 deg", 60), ("-90 deg", -90), ("60deg", 60), ("1 rad", 180 / math.pi), ("0.25 revolution", 90),
        ("1 rev / 4", 90), ("45°", 45), ("-#reach", -30), ("2 * #twice + 15 degrees", 135),
        ("atan2(3 mm, 3 mm)", 45), ("asin(1/2)", 30), ("acos(0) - atan(1)", 45),
        ("round(47 deg, 10 deg)", 50), ("floor(47 deg, 10 deg)", 40), ("ceil(41 deg, 10 deg)", 50),
        ("abs(-20 deg)", 20), ("min(3 rad, 20 deg, 1 rev)", 20), ("max(10 deg, 20 deg)", 20),
        ("370 deg % 360 deg", 10), ("#flag ? 10 deg : 20 deg", 20),
        ("#reach < 1 rad && !#flag ? 10 deg : 20 deg", 10), ("true || 1/0 > 1 ? 10 deg : 20 deg", 10),
        ("#reach == 30 deg ? 10 deg : 20 deg", 10), ("0", 0), ("PI * 1 rad", 180), ("PI/2 rad", 90),
        ("-PI/2 rad", -90), ("3*PI/4 rad", 135), ("2 * PI / 3 rad", 120), ("PI/2*rad", 90),
        ("180/PI deg", 180 / math.pi), ("PI rad", 180), ("1 rev 30 deg", 390),
    ],
)  # fmt: skip
def test_angles(text, degrees):
    assert angle(text) == pytest.approx(degrees * DEGREE, abs=1e-15)


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("0 in", 0), ("0.0*mm", 0), ("1/2 in", 0.0127), ("#wide", 0.0127), ("3 mm + 0.2 cm - .001m", 0.004),
        ("1 ft + 1 yd", 1.2192), ("sqrt(4 mm^2)", 0.002), ("sqrt(3^2 + 4^2) mm", 0.005),
        ("hypot(3 mm, 4 mm)", 0.005), ("2 m * sin(30 deg)", 1.0), ("tan(45 deg) * 1e-3 meter", 0.001),
        ("10 mm * 10 mm / 5 mm", 0.02), ("2 * -1/2 in", -0.0254), ("6 in / 1/2 in * 1 mm", 0.012),
        ("2^3 mm", 0.008), ("#twice / #reach * (1 + 1) mm", 0.004), ("2^-1 m", 0.5), ("2^3^0 m", 2.0),
        ("-2^2 m", -4.0), ("(-2)^2 m", 4.0), ("exp(0) millimeter", 0.001), ("log10(100) mm * cosh(0)", 0.002),
        ("1 ft 2 in", 14 * 0.0254), ("1ft 2in", 14 * 0.0254), ("-1 ft 2 in", -14 * 0.0254),
        ("2 * 1 ft 2 in", 28 * 0.0254), ("1 ft 2 in + 1 in", 15 * 0.0254),
        ("1 yd 1 ft 2 1/2 in", 50.5 * 0.0254), ("1'", 0.3048), ('1"', 0.0254), ("1' 2\"", 14 * 0.0254),
        ("1'2 1/2\"", 14.5 * 0.0254), ("1′ 2″", 14 * 0.0254), ("1 1/2 in", 1.5 * 0.0254),
        ("-1 1/2 in", -1.5 * 0.0254), ("1 1/2 in * 2", 3 * 0.0254), ("1 1/2 * 2 in", 3 * 0.0254),
        ("6 in / 1 1/2 in * 1 mm", 0.004), ("250 thou", 250 * 2.54e-5), ("10 mil", 2.54e-4),
        ("0.001 km", 1.0), ("2 kilometers / 1000", 2.0), ("1 mile", 1609.344), ("3 µm", 3e-6),
        ("roundToPrecision(12.3456, 2) mm", 0.01235), ("roundToPrecision(-1.25, 1) mm", -0.0012),
        ("roundToPrecision(1234, -2) mm", 1.2), ("clamp(5 mm, 1 mm, 3 mm)", 0.003),
        ("exp2(3) mm + asinh(0) mm", 0.008), ("5 mm^2 / 1 mm", 0.005),
    ],
)  # fmt: skip
def test_lengths(text, metres):
    assert length(text) == pytest.approx(metres, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("5 mm", "expected an angle, got a length"), ("7", "expected an angle, got a number"),
        ("5 mm^2", "expected an angle, got an area"), ("1 deg * 1 mm", "m^(1)·rad^(1)"),
        ("#flag", "expected an angle, got true or false"), ("1/#reach mm", "m^(-1)·rad^(-1)"),
        ("1 deg + 1 mm", "'+' needs two values of the same dimension, not an angle and a length"),
        ("min(1 deg, 1)", "min() needs two values of the same dimension, not an angle and a number"),
        ("sin(3)", "sin() takes an angle, not a number: write its unit, sin(30 deg)"),
        ("asin(2)", "asin(2) is not defined"), ("asin(1 mm)", "asin() takes a number, not a length"),
        ("sqrt(-1)", "sqrt() of a negative value"), ("round(3, 0)", "round() to multiples of zero"),
        ("(-8)^(1/3)", "a negative number to a fractional power"),
        ("2^(1 deg)", "an exponent must be a number, not an angle"),
        ("(1 mm)^99", "a power above 64 of a quantity with a unit"), ("1/0", "a division by zero"),
        ("1 % 0", "a division by zero"), ("9^9^9^9", "a value is not finite"),
        ("1e300*1e300", "a value is not finite"), ("1e999", "a value is not finite"),
        ("1 deg ? 2 : 3", "a condition must be true or false, not an angle"),
        ("true + 1", "'+' takes quantities, not true or false"),
        ("abs(true)", "abs() takes quantities, not true or false"),
        ("-true", "'-' takes a quantity, not true or false"), ("foo(2)", "the function foo() is not known"),
        ("atan2(1)", "atan2() takes 2 values and got 1"),
        ("roundToPrecision(1 mm, 2)", "roundToPrecision() takes a number and a whole number of"),
        ("roundToPrecision(1, 0.5)", "roundToPrecision() takes a number and a whole number of"),
        ("roundToPrecision(1, 999)", "roundToPrecision() to more than 300 places"),
        ("roundToPrecision(1e300, 300)", "a value is not finite"),
        ("2 in 1 ft", "'ft' is not expected there: it is no smaller than the unit before it"),
        ("1 ft 2", "a number without a unit follows a number with a unit"),
        ("1 ft 2 deg", "'+' needs two values of the same dimension, not a length and an angle"),
        ("furlong", "'furlong' is no unit"), ("sin", "'sin' is no unit (a function needs its parentheses)"),
        ("3 4", "'4' is not expected there"), ("3 #reach", "'#reach' is not expected there"),
        ("(1 deg", "')' is expected at the end"), ("1 deg)", "')' is not expected there"),
        ("1 +", "it is incomplete"), ("", "it is incomplete"), ("5 $", "'$' is not understood"),
        ("#", "'#' is not understood"), ("true ? 1 deg", "':' is expected at the end"),
        ("(" * 99 + "1" + ")" * 99, "it is nested more than 60 deep"),
        ("+".join(["1"] * 999), "it has more than 400 tokens"),
    ],
)  # fmt: skip
def test_an_expression_without_a_value_is_reported(text, message):
    with pytest.raises(ExpressionError) as caught:
        angle(text)
    assert message in str(caught.value)


def test_an_unknown_variable_is_named_however_deep_it_lies():
    scope = Scope({"a": "#b + 1 deg", "b": "2 * #lost"})
    with pytest.raises(UnknownVariable, match="the variable #lost is not known") as caught:
        measured("-#a", "angle", scope)
    assert caught.value.name == "lost"


def test_variables_that_define_each_other_are_reported():
    scope = Scope({"a": "#b", "b": "#c", "c": "#b"})
    with pytest.raises(ExpressionError, match="#b → #c → #b"):
        evaluate("#a", scope)


def test_long_chains_of_variables_end_in_an_error():
    chain = {f"v{n}": "+".join([f"#v{n + 1}", *["1"] * 190]) for n in range(200)}
    with pytest.raises(ExpressionError, match="deep"):
        evaluate("#v0", Scope(chain))


def test_a_shown_value_replaces_an_expression_nobody_understands():
    scope = Scope({"a": "lookup(3)", "b": "#a * 2"}, {"a": "12.35 deg", "b": "24.7 deg"})
    assert measured("#b", "angle", scope) == pytest.approx(24.7 * DEGREE)
    assert scope.rounded == {"a"}
    scope.rounded.clear()
    assert measured("#b", "angle", scope) == pytest.approx(24.7 * DEGREE)
    assert scope.rounded == {"b"}
