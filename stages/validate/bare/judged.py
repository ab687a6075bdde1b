"""Judgements of single numbers that are the same in every format."""

import math
from collections.abc import Iterator

import numpy as np

from linkwright.stages.robot.dynamics.inertia import principal
from linkwright.stages.robot.model.robot import Array

TRIANGLE = 1e-3
"""By how much, relative to the largest moment, A + B ≥ C may be missed: files have few digits."""

_NAMES = ("ixx", "iyy", "izz")


def wrong_mass(mass: float, moves: bool) -> Iterator[str]:
    """Why a mass [kg] cannot be that of a link. `moves`: whether the link is on a joint that moves; another
    link needs no mass."""
    if mass < 0.0 or (moves and not mass > 0.0):
        yield f"{mass:g} kg: a mass is above zero"


def wrong_inertia(tensor: Array) -> Iterator[tuple[str, str]]:
    """Why a tensor [kg m²] is not that of a solid, and by which of its entries: a moment that is not
    positive, principal moments that are not, or A + B < C."""
    for name, moment in zip(_NAMES, np.diag(tensor).tolist(), strict=True):
        if moment <= 0.0:
            yield name, f"{moment:g} kg·m²: a moment of inertia is above zero"
            return
    low, middle, high = principal(tensor).tolist()
    worst = _largest_product(tensor)
    if low <= -TRIANGLE * high or low == 0.0:
        shown = ", ".join(f"{one:.3g}" for one in (low, middle, high))
        yield worst, f"the inertia is not positive definite: its principal moments are {shown} kg·m²"
    elif low + middle < high * (1.0 - TRIANGLE):
        moments = np.diag(tensor)
        name = _NAMES[int(moments.argmax())]
        own = 2.0 * moments.max() > moments.sum() * (1.0 - TRIANGLE)
        shown = f"{low:.3g} + {middle:.3g} < {high:.3g} kg·m²"
        yield name if own else worst, f"no solid has this inertia, by the triangle inequality: {shown}"


def _largest_product(tensor: Array) -> str:
    products = {"ixy": tensor[0, 1], "ixz": tensor[0, 2], "iyz": tensor[1, 2]}
    return max(products, key=lambda name: abs(products[name]))


def in_degrees(angle: float) -> bool:
    """Whether an angle that should be in radians looks like an angle in degrees: more than two turns as
    radians, at most two as degrees. Smaller angles such as 10, and huge angles, often stand for no limit."""
    size = abs(angle)
    return 4.0 * math.pi + 0.01 < size <= 720.0 and not _whole_turns(size)


def _whole_turns(size: float) -> bool:
    turns = size / (2.0 * math.pi)
    return abs(turns - round(turns)) < 1e-3
