"""Formats the numbers in robot files: no other module does. NaN and infinity are errors.

Each number is the shortest text within 1e-12 of its vector's largest entry, so noise such as 1e-17 next to
0.3 is written as 0, and 0.1 + 0.2 as 0.3. There is no "-0". A vector that may be all noise, such as a
position at an origin, is measured by `least` if its entries are smaller: `LENGTH` for metres, `TURN` for
radians and for vectors of unit length.
"""

import math
from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np

from linkwright.stages.robot.model.robot import Array

TOLERANCE = 1e-12
"""Tolerance of a text, relative to the scale of its number."""

LENGTH = 0.1
"""Scale of positions [m]: below a tenth of a picometre they are noise."""

TURN = 1.0
"""Scale of angles [rad], and of the entries of vectors of unit length."""

FORCE = 1.0
"""Scale of forces that balance [N or N m]."""

WHOLE = 1e15
"""Size below which whole numbers are exact, and written out."""


def number(value: float, scale: float | None = None, least: float = 0.0) -> str:
    """Returns the shortest text within 1e-12 · `scale` of `value`. Raises ValueError for NaN and infinity.

    `scale` is |value| by default; `least` replaces it if that is larger.
    """
    value = float(value)
    _require_finite((value,))
    tolerance = TOLERANCE * max(least, abs(value) if scale is None else scale)
    return _text(value, tolerance, _grid(tolerance))


def _require_finite(values: Sequence[float]) -> None:
    # The scale of NaN is none, and that of infinity makes every other entry noise.
    if not all(map(math.isfinite, values)):
        msg = f"{', '.join(map(str, values))}: not finite"
        raise ValueError(msg)


def _text(value: float, tolerance: float, grid: "_Grid") -> str:
    """Returns the shortest text within `tolerance` of `value`; `grid` is the grid of the tolerance."""
    size = abs(value)
    if size <= tolerance:
        return "0"
    if grid is not None and 1e-4 <= size < 1e4 and tolerance > 1e-15 * size:
        spec, in_doubt = grid
        text = format(value, spec)
        if text[-1] not in in_doubt:
            return text
        if text[-1] == "0":
            return text.rstrip("0").rstrip(".")
    if tolerance < 1.0 and size < WHOLE and value.is_integer():
        return str(int(value))
    # On a finer grid the nearest point is never further away: the search goes one way from a good guess.
    digits = 17
    if tolerance > 1e-18 * size:
        digits = min(17, max(1, math.ceil(math.log10(0.5 * size / tolerance))))
    text = f"{value:.{digits}g}"
    if abs(float(text) - value) > tolerance:
        while digits < 17 and abs(float(text) - value) > tolerance:
            digits += 1
            text = f"{value:.{digits}g}"
        return tidy(text if abs(float(text) - value) <= tolerance else repr(value))
    while digits > 1:
        shorter = f"{value:.{digits - 1}g}"
        if abs(float(shorter) - value) > tolerance:
            break
        text, digits = shorter, _digits(shorter)
    return tidy(text if size < 1e4 else f"{value:.{digits}g}")


_Grid: TypeAlias = tuple[str, str] | None
"""The format with the fewest decimals that are always within a tolerance, and the last digits for which one
decimal fewer may be enough."""


def _grid(tolerance: float) -> _Grid:
    """Returns the grid of a tolerance; None if whole numbers are enough, or no decimals are."""
    if not 1e-19 < tolerance < 0.01:
        return None
    decimals = math.ceil(-math.log10(2.0 * tolerance) + 1e-9)
    # Without its last digit c a number moves by |c| or |10 - c| of the grid, and half of it is lost already.
    reach = int(tolerance * _TENS[decimals] + 0.5 + 1e-6)
    return _SPECS[decimals], _IN_DOUBT[min(reach, 5)]


_SPECS = tuple(f".{decimals}f" for decimals in range(20))
_TENS = tuple(10.0**decimals for decimals in range(20))

_IN_DOUBT = tuple("".join(str(c) for c in range(10) if min(c, 10 - c) <= reach) for reach in range(6))
"""The last digits in doubt, by the reach of the tolerance on the grid."""


def _digits(text: str) -> int:
    """Counts the digits of a number's text, from the first to the last that is not zero."""
    return len(text.partition("e")[0].replace("-", "").replace(".", "").strip("0"))


def tidy(text: str) -> str:
    """Returns the text with a short exponent ("1e-05" → "1e-5"), or written out if whole ("1e+02" →
    "100")."""
    if "e" not in text:
        return text
    mantissa, exponent = text.split("e")
    power = int(exponent)
    if 0 <= power < 16:
        return str(int(float(text)))
    return f"{mantissa}e{power}"


def numbers(values: Iterable[float], scale: float | None = None, least: float = 0.0) -> list[str]:
    """Returns the texts of a vector or tensor, all measured by its largest entry, or by `least` if that is
    larger. Raises ValueError for NaN and infinity."""
    entries = values.ravel().tolist() if isinstance(values, np.ndarray) else values
    flat = [float(value) for value in entries]
    _require_finite(flat)
    largest = max(map(abs, flat), default=0.0) if scale is None else scale
    tolerance = TOLERANCE * max(least, largest)
    grid = _grid(tolerance)
    return [_text(value, tolerance, grid) for value in flat]


def rounded_tensor(tensor: Array) -> Array:
    """Returns a symmetric tensor (3, 3) with the values of its texts."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = tensor.tolist()
    xx, xy, xz, yy, yz, zz = map(float, numbers([xx, xy, xz, yy, yz, zz]))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def spaced(values: Iterable[float], scale: float | None = None, least: float = 0.0) -> str:
    """Returns a vector as XML attributes have it: "0 0 0.3"."""
    return " ".join(numbers(values, scale, least))


def exact(values: Iterable[float]) -> str:
    """Returns a vector without any rounding, in 12 digits if these are exact."""
    return " ".join(
        f"{value:.12g}" if float(f"{value:.12g}") == value else f"{value:.17g}" for value in values
    )


def least_of(kind: str) -> float:
    """Returns the scale of the values of a dof of this kind: that of metres for a slide, of radians for
    others."""
    return LENGTH if kind == "slide" else TURN
