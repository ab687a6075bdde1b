"""Judges masses, inertias and angles, by rules that are the same in every format."""

import math
from collections.abc import Iterator

import numpy as np

from linkwright.stages.robot.dynamics.inertia import principal
from linkwright.stages.robot.model.robot import Array

TRIANGLE_TOLERANCE = 1e-3
"""Tolerance of the triangle inequality A + B ≥ C of the principal moments, relative to the largest moment:
files have few digits."""

_DIAGONAL_NAMES = ("ixx", "iyy", "izz")
"""Names of the moments of inertia, in the order of the tensor's diagonal."""


def mass_faults(mass: float, moves: bool) -> Iterator[str]:
    """Yields the reasons why a mass [kg] cannot be that of a link. `moves`: whether the link is on a joint
    that moves; other links need no mass."""
    if mass < 0.0 or (moves and not mass > 0.0):
        yield f"{mass:g} kg: a mass is above zero"


def inertia_faults(tensor: Array) -> Iterator[tuple[str, str]]:
    """Yields (name of an entry, reason) if a tensor (3, 3) [kg m²] cannot be that of a solid: a moment or a
    principal moment is not positive, or A + B < C for the principal moments."""
    for name, moment in zip(_DIAGONAL_NAMES, np.diag(tensor).tolist(), strict=True):
        if moment <= 0.0:
            yield name, f"{moment:g} kg·m²: a moment of inertia is above zero"
            return
    low, middle, high = principal(tensor).tolist()
    product_name = _largest_product(tensor)
    if low <= -TRIANGLE_TOLERANCE * high or low == 0.0:
        shown = ", ".join(f"{moment:.3g}" for moment in (low, middle, high))
        yield product_name, f"the inertia is not positive definite: its principal moments are {shown} kg·m²"
    elif low + middle < high * (1.0 - TRIANGLE_TOLERANCE):
        moments = np.diag(tensor)
        # The moments themselves may break the inequality; if not, the products of inertia do.
        by_moments = 2.0 * moments.max() > moments.sum() * (1.0 - TRIANGLE_TOLERANCE)
        name = _DIAGONAL_NAMES[int(moments.argmax())] if by_moments else product_name
        shown = f"{low:.3g} + {middle:.3g} < {high:.3g} kg·m²"
        yield name, f"no solid has this inertia, by the triangle inequality: {shown}"


def _largest_product(tensor: Array) -> str:
    """Returns the name of the largest product of inertia, by its absolute value."""
    products = {"ixy": tensor[0, 1], "ixz": tensor[0, 2], "iyz": tensor[1, 2]}
    return max(products, key=lambda name: abs(products[name]))


def looks_like_degrees(angle: float) -> bool:
    """Tells whether an angle that should be in radians looks like degrees: as radians it would be more than
    two turns, and as degrees at most two. Other values often mean no limit: small numbers such as 10, huge
    numbers, and whole turns in radians."""
    size = abs(angle)
    # 0.01: four pi may be rounded to two digits.
    return 4.0 * math.pi + 0.01 < size <= 720.0 and not _is_whole_turns(size)


def _is_whole_turns(size: float) -> bool:
    """Tells whether an angle [rad] is a whole number of turns, to a thousandth of a turn."""
    turns = size / (2.0 * math.pi)
    return abs(turns - round(turns)) < 1e-3
