"""Limits carried over to values that are counted in another way."""

from hypothesis import given
from hypothesis import strategies as st

from linkwright.stages.robot.model.dofs import LimitOrigin, Limits

# Multiples of 1/8: sums of them are exact.
EIGHTHS = st.integers(-80, 80).map(lambda number: number / 8)
ENDS = st.none() | EIGHTHS
RANGES = st.tuples(ENDS, ENDS).filter(lambda ends: None in ends or ends[0] <= ends[1])
SIGNS = st.sampled_from([-1, 1])


@given(RANGES, SIGNS, EIGHTHS)
def test_mapped_and_mapped_back_limits_are_themselves(ends, sign, shift):
    limits = Limits(*ends)
    assert limits.mapped(sign, shift).mapped(sign, -sign * shift) == limits


@given(RANGES, st.sampled_from([-4.0, -1.0, -0.5, 0.5, 1.0, 2.0]), EIGHTHS, EIGHTHS)
def test_mapped_limits_contain_the_mapped_values(ends, factor, shift, value):
    limits = Limits(*ends)
    assert limits.mapped(factor, shift).contains(factor * value + shift) == limits.contains(value)


@given(RANGES, EIGHTHS)
def test_a_factor_of_zero_leaves_one_value(ends, shift):
    assert Limits(*ends).mapped(0, shift) == Limits(shift, shift)


def test_mapped_limits_keep_their_origin():
    origin = LimitOrigin(doubts=("typed twice",))
    assert Limits(0.0, None, origin=origin).mapped(-1).origin == origin
