"""Computes the axes of a plot: the position of a value, and the values with a label."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

MIN_LOG_RATIO = 30.0
"""Least ratio of the largest to the smallest of positive values for a logarithmic axis."""

MAX_INTERVALS = 5
"""Largest number of intervals between labelled values."""

PADDING = 0.06
"""Space on either side of the outermost values, as a share of their range."""


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis of a plot, from the value `low` to the value `high`."""

    title: str
    low: float
    high: float
    ticks: tuple[tuple[float, str], ...]
    """The values with a label, and the labels."""
    log: bool = False
    """Whether the axis is logarithmic."""
    discrete: bool = False
    """Whether the values are categories, which no line joins."""

    def share(self, value: float) -> float:
        """Returns the position of a value: 0 at the low end, 1 at the high end."""
        low, high, position = (
            math.log10(number) if self.log else number for number in (self.low, self.high, value)
        )
        return (position - low) / (high - low)


def numbers(title: str, values: Sequence[float], *, may_be_log: bool = False) -> Axis:
    """Returns the axis of numbers; `values` must be finite and not empty."""
    low, high = min(values), max(values)
    if may_be_log and low > 0.0 and high / low >= MIN_LOG_RATIO:
        pad = (high / low) ** PADDING
        return Axis(title, low / pad, high * pad, _decades(low, high), log=True)
    if low == high:
        pad = abs(low) / 2 or 1.0
    else:
        pad = PADDING * (high - low)
    min_step = 1.0 if all(float(value).is_integer() for value in values) else 0.0
    return Axis(title, low - pad, high + pad, _round_values(low - pad, high + pad, min_step))


def categories(title: str, names: Sequence[str]) -> Axis:
    """Returns the axis of categories, which are at 0, 1, 2, ..."""
    ticks = tuple((float(at), name) for at, name in enumerate(names))
    return Axis(title, -0.5, len(names) - 0.5, ticks, discrete=True)


def _round_values(low: float, high: float, min_step: float) -> tuple[tuple[float, str], ...]:
    """Returns multiples of 1, 2 or 5 times a power of ten, at least `min_step` apart (1 for whole
    numbers)."""
    min_step = max(min_step, (high - low) / MAX_INTERVALS)
    power = math.floor(math.log10(min_step))
    step = (
        next(factor for factor in (1, 2, 5, 10) if factor * 10.0**power >= min_step * (1 - 1e-9))
        * 10.0**power
    )
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return tuple((at * step, _text(at * step, decimals)) for at in range(first, last + 1))


def _text(value: float, decimals: int) -> str:
    if decimals > 6 or abs(value) >= 1e7:
        return f"{value:.4g}"
    # Adding 0.0 turns -0.0 into 0.0.
    return f"{value + 0.0:,.{decimals}f}"


def _decades(low: float, high: float) -> tuple[tuple[float, str], ...]:
    """Returns the powers of ten in a range; within few decades also their doubles and fivefolds."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    step = max(1, math.ceil((last - first) / MAX_INTERVALS))
    factors = (1, 2, 5) if last - first <= 2 else (1,)
    values = [factor * 10.0**power for power in range(first, last + 1, step) for factor in factors]
    return tuple((value, f"{value:.6g}") for value in values if low * 0.999 <= value <= high * 1.001)
