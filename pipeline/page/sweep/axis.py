"""The axes of a plot: where a value stands, and which values are named."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

LOG = 30.0
"""Positive values that lie apart by this factor stand by their logarithm."""

MOST = 5
"""Intervals between the values that are named, at most."""

PAD = 0.06
"""Room on either side of the outermost values, as a share of their range."""


@dataclass(frozen=True, slots=True)
class Axis:
    """A `title`, the values at both ends, and the named values with their texts. `log`: by their logarithm;
    `discrete`: categories, which no line joins."""

    title: str
    low: float
    high: float
    ticks: tuple[tuple[float, str], ...]
    log: bool = False
    discrete: bool = False

    def share(self, value: float) -> float:
        """Where a value stands: 0 at the low end, 1 at the high one."""
        low, high, at = (math.log10(one) if self.log else one for one in (self.low, self.high, value))
        return (at - low) / (high - low)


def numbers(title: str, values: Sequence[float], *, may_be_log: bool = False) -> Axis:
    """The axis of numbers, which are finite and at least one."""
    low, high = min(values), max(values)
    if may_be_log and low > 0.0 and high / low >= LOG:
        pad = (high / low) ** PAD
        return Axis(title, low / pad, high * pad, _decades(low, high), log=True)
    if low == high:
        pad = abs(low) / 2 or 1.0
    else:
        pad = PAD * (high - low)
    least = 1.0 if all(float(one).is_integer() for one in values) else 0.0
    return Axis(title, low - pad, high + pad, _round_values(low - pad, high + pad, least))


def categories(title: str, names: Sequence[str]) -> Axis:
    """The axis of categories, which stand at 0, 1, 2, ..."""
    ticks = tuple((float(at), name) for at, name in enumerate(names))
    return Axis(title, -0.5, len(names) - 0.5, ticks, discrete=True)


def _round_values(low: float, high: float, least: float) -> tuple[tuple[float, str], ...]:
    """Multiples of 1, 2 or 5 times a power of ten, at least `least` apart: of whole numbers, whole ones."""
    least = max(least, (high - low) / MOST)
    power = math.floor(math.log10(least))
    step = next(one for one in (1, 2, 5, 10) if one * 10.0**power >= least * (1 - 1e-9)) * 10.0**power
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return tuple((at * step, _text(at * step, decimals)) for at in range(first, last + 1))


def _text(value: float, decimals: int) -> str:
    if decimals > 6 or abs(value) >= 1e7:
        return f"{value:.4g}"
    return f"{value + 0.0:,.{decimals}f}"


def _decades(low: float, high: float) -> tuple[tuple[float, str], ...]:
    """Powers of ten; of few decades also 2 and 5 times as much."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    every = max(1, math.ceil((last - first) / MOST))
    factors = (1, 2, 5) if last - first <= 2 else (1,)
    values = [factor * 10.0**power for power in range(first, last + 1, every) for factor in factors]
    return tuple((value, f"{value:.6g}") for value in values if low * 0.999 <= value <= high * 1.001)
