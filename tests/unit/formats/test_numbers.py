"""The one formatter of numbers."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from linkwright.stages.formats.numbers import LENGTH, TOLERANCE, TURN, least_of, number, numbers, spaced, tidy

finite = st.floats(-1e9, 1e9, allow_nan=False, allow_subnormal=False)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1"),
        (0.1 + 0.2, "0.3"),
        (1 / 3, "0.333333333333"),
        (-2.5, "-2.5"),
        (100.0, "100"),
        (1e-5, "1e-5"),
        (123456789.0, "123456789"),
        (1e20, "1e20"),
    ],
)
def test_numbers_are_as_short_as_they_can_be(value: float, text: str) -> None:
    assert number(value) == text


def test_noise_beside_a_large_entry_is_zero() -> None:
    assert spaced([0.3, 1e-17, -2e-13]) == "0.3 0 0"
    assert spaced([0.3, 1e-9, 0]) == "0.3 1e-9 0"


def test_a_vector_of_zeros_is_zeros() -> None:
    assert spaced([0.0, -0.0, 0.0]) == "0 0 0"


def test_a_vector_that_is_all_noise_is_measured_by_what_it_is() -> None:
    assert spaced([8e-15, -1e-13, 0.1]) == "0 0 0.1"
    assert spaced([8e-15, -9e-14, 0.0]) == "8e-15 -9e-14 0"
    assert spaced([8e-15, -9e-14, 0.0], least=LENGTH) == "0 0 0"
    assert spaced([3e-13, 0.0, 0.0], least=LENGTH) == "3e-13 0 0"
    assert spaced([3e-13, -0.0, 200.0], least=LENGTH) == "0 0 200"
    assert number(-9e-13, least=TURN) == "0"
    assert number(-9e-13, least=least_of("slide")) == "-9e-13"
    assert [least_of(kind) for kind in ("turn", "slide", "ball")] == [TURN, LENGTH, TURN]


@given(st.lists(finite, min_size=1, max_size=9))
def test_every_entry_is_within_the_tolerance_of_the_largest(values: list[float]) -> None:
    texts = numbers(values)
    largest = max(map(abs, values))
    for value, text in zip(values, texts, strict=True):
        assert abs(float(text) - value) <= TOLERANCE * largest
        assert text != "-0"


@settings(max_examples=2000)
@given(
    finite | st.integers(-(10**17), 10**17).map(float) | st.integers(-(10**7), 10**7).map(lambda n: n / 1000),
    st.none() | st.floats(0.0, 1e13),
)
@example(1e16, None)
@example(999999.0, 1e12)
def test_the_text_is_the_first_that_is_near_enough(value: float, scale: float | None) -> None:
    """Every number of digits is tried, from one on."""
    tolerance = TOLERANCE * (abs(value) if scale is None else scale)
    texts = [f"{value:.{digits}g}" for digits in range(1, 18)]
    near = [text for text in texts if abs(float(text) - value) <= tolerance]
    expected = "0" if abs(value) <= tolerance else tidy([*near, repr(value)][0])
    assert number(value, scale) == expected


@given(finite)
def test_no_shorter_text_would_do(value: float) -> None:
    text = number(value)
    digits = len(text.lstrip("-").split("e")[0].replace(".", "").strip("0"))
    if digits > 1:
        shorter = float(f"{value:.{digits - 1}g}")
        assert abs(shorter - value) > TOLERANCE * abs(value)
