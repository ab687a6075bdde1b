"""The formatter of numbers."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from linkwright.stages.formats.numbers import LENGTH, TOLERANCE, TURN, least_of, number, numbers, spaced, tidy
from tests.support.drawn import each

finite = st.floats(-1e9, 1e9, allow_nan=False, allow_subnormal=False)


@pytest.mark.parametrize(("value", "text"), [
    (0.0, "0"), (-0.0, "0"), (1.0, "1"), (0.1 + 0.2, "0.3"), (1 / 3, "0.333333333333"), (-2.5, "-2.5"),
    (100.0, "100"), (1e-5, "1e-5"), (123456789.0, "123456789"), (1e20, "1e20"),
])  # fmt: skip
def test_numbers_are_as_short_as_they_can_be(value, text):
    assert number(value) == text


@pytest.mark.parametrize(("values", "least", "text"), [
    ([0.3, 1e-17, -2e-13], None, "0.3 0 0"),
    ([0.3, 1e-9, 0], None, "0.3 1e-9 0"),
    ([0.0, -0.0, 0.0], None, "0 0 0"),
    ([8e-15, -1e-13, 0.1], None, "0 0 0.1"),
    ([8e-15, -9e-14, 0.0], None, "8e-15 -9e-14 0"),
    ([8e-15, -9e-14, 0.0], LENGTH, "0 0 0"),
    ([3e-13, 0.0, 0.0], LENGTH, "3e-13 0 0"),
    ([3e-13, -0.0, 200.0], LENGTH, "0 0 200"),
])  # fmt: skip
def test_noise_beside_a_large_entry_or_below_the_least_is_zero(values, least, text):
    assert spaced(values, **({} if least is None else {"least": least})) == text


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_number_that_is_not_finite_is_refused(value):
    with pytest.raises(ValueError, match="not finite"):
        number(value)
    with pytest.raises(ValueError, match="not finite"):
        spaced([1.0, value], least=LENGTH)


def test_least_value_depends_on_the_kind_of_a_dof():
    assert number(-9e-13, least=TURN) == "0"
    assert number(-9e-13, least=least_of("slide")) == "-9e-13"
    assert [least_of(kind) for kind in ("turn", "slide", "ball")] == [TURN, LENGTH, TURN]


@given(st.lists(finite, min_size=1, max_size=9))
def test_each_entry_is_within_the_tolerance_of_the_largest(values):
    texts = numbers(values)
    largest = max(map(abs, values))
    for value, text in zip(values, texts, strict=True):
        assert abs(float(text) - value) <= TOLERANCE * largest
        assert text != "-0"


@pytest.mark.parametrize("count", [500, pytest.param(2000, marks=pytest.mark.slow)])
def test_text_is_the_shortest_that_is_near_enough(count):
    """Tries each number of digits, from 1 on."""

    def is_shortest(value, scale):
        tolerance = TOLERANCE * (abs(value) if scale is None else scale)
        texts = [f"{value:.{digits}g}" for digits in range(1, 18)]
        near = [text for text in texts if abs(float(text) - value) <= tolerance]
        expected = "0" if abs(value) <= tolerance else tidy([*near, repr(value)][0])
        assert number(value, scale) == expected

    is_shortest(1e16, None)
    is_shortest(999999.0, 1e12)
    whole, thousandths = st.integers(-(10**17), 10**17).map(float), st.integers(-(10**7), 10**7)
    values = finite | whole | thousandths.map(lambda n: n / 1000)
    each(is_shortest, count, values, st.none() | st.floats(0.0, 1e13))
