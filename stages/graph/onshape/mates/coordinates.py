"""Expresses the coordinates of a mate by those of another mate between the same two bodies."""

import math
from dataclasses import dataclass

import numpy as np

from linkwright.stages.graph.dofs import value_in
from linkwright.stages.graph.onshape.mates.twists import ALIKE, View, chain
from linkwright.stages.robot.model.poses import inverse, quat_from_rotation, rotation_from_quat
from linkwright.stages.robot.model.robot import Array, Limits, Value

NOISE = 1e-10
"""An offset [rad or m] below this is rounding."""

_SAMPLES = 12


@dataclass(frozen=True, slots=True)
class Tie:
    """In every motion the coordinate changes by `factor` times the change of the other mate's dof number
    `onto`; a factor of 0 is a coordinate that stays as it is."""

    onto: int
    factor: float


def ties(of: View, onto: View, size: float) -> tuple[Tie | None, ...]:
    """The tie of each coordinate of a mate to those of one that moves within it.

    None is a coordinate that does not follow from a single one, in proportion. Coordinates are turns,
    slides, and of a ball the angle of its cone. They are fitted at poses around the saved one, less
    than half a turn away; `size` [m] is the scale of slides.
    """
    poses = _poses_around(onto, size)
    moves = np.array([changes(onto, pose) for pose in poses])
    follows = np.array([changes(of, pose if of.bodies == onto.bodies else inverse(pose)) for pose in poses])
    reach = np.abs(moves).max(axis=0)
    made: list[Tie | None] = []
    for dof, column in zip(of.dofs, follows.T, strict=True):
        least = ALIKE * (size if dof.kind == "slide" else 1.0)
        factors = np.linalg.lstsq(moves, column, rcond=None)[0]
        driving = np.flatnonzero(np.abs(factors) * reach > least)
        if np.abs(moves @ factors - column).max() > least or len(driving) > 1:
            made.append(None)
        elif len(driving) == 0:
            made.append(Tie(0, 0.0))
        else:
            made.append(Tie(int(driving[0]), round(float(factors[driving[0]]), 12)))
    return tuple(made)


def _poses_around(one: View, size: float) -> list[Array]:
    """Displacements (4, 4, in the world) of the first body against the second, as the mate allows them."""
    rng = np.random.default_rng(0)
    made = []
    back = inverse(chain(one.dofs, one.saved))
    for _ in range(_SAMPLES):
        values = [
            _near(value, rng.uniform(-1.0, 1.0, 4), size if dof.kind == "slide" else 1.0)
            for dof, value in zip(one.dofs, one.saved, strict=True)
        ]
        moved = chain(one.dofs, values) @ back
        made.append(one.second @ moved @ inverse(one.second))
    return made


def _near(value: Value, step: Array, unit: float) -> Value:
    if not isinstance(value, tuple):
        return value + float(step[0]) * unit
    turned = rotation_from_quat(np.array(value)) @ rotation_from_quat(np.array([2.0, *step[1:]]))
    return tuple(float(number) for number in quat_from_rotation(turned))


def changes(one: View, displacement: Array) -> Array:
    """The changes (n,) of a mate's coordinates as its first body is displaced relative to its second."""
    before = coordinates(one, np.eye(4))
    after = coordinates(one, displacement)
    turns = np.array([dof.kind == "turn" for dof in one.dofs])
    change = after - before
    return np.where(turns, np.remainder(change + math.pi, math.tau) - math.pi, change)


def coordinates(one: View, displacement: Array) -> Array:
    """Turns [rad], slides [m] and cone angles [rad] (n,) with the first body displaced (4, 4)."""
    relative = inverse(one.second) @ displacement @ one.first
    return np.array([
        math.atan2(math.hypot(relative[0, 2], relative[1, 2]), relative[2, 2])
        if dof.kind == "ball" else value_in(relative, dof.kind, dof.axis)
        for dof in one.dofs
    ])  # fmt: skip


def carried(limits: Limits, here: float, tie: Tie, there: float) -> Limits:
    """Limits of a coordinate with the value `here` as limits of the dof that it is tied to, with the value
    `there`."""
    offset = here - tie.factor * there
    offset = 0.0 if abs(offset) < NOISE else offset
    return limits.mapped(1 / tie.factor, -offset / tie.factor)
