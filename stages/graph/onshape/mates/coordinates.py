"""Expresses the coordinates of a mate by those of another mate between the same two bodies."""

import math
from dataclasses import dataclass

import numpy as np

from linkwright.stages.graph.dofs import value_in
from linkwright.stages.graph.onshape.mates.twists import ANGLE_TOLERANCE, MateView, chain
from linkwright.stages.robot.model.poses import inverse, quat_from_rotation, rotation_from_quat
from linkwright.stages.robot.model.robot import Array, Limits, Value

OFFSET_TOLERANCE = 1e-10
"""Largest offset [rad or m] that counts as rounding."""

_SAMPLES = 12
"""Number of poses to which a coupling is fitted."""


@dataclass(frozen=True, slots=True)
class CoordinateCoupling:
    """A coordinate of a mate that changes in proportion to a dof of another mate."""

    dof_index: int
    """Index of the dof in the other mate."""
    factor: float
    """Change of the coordinate over change of the dof; 0 for a coordinate that does not change."""


def coordinate_couplings(
    follower: MateView, driver: MateView, size: float
) -> tuple[CoordinateCoupling | None, ...]:
    """Returns the coupling of each coordinate of the mate `follower` to a dof of the mate `driver`, whose
    motions it allows; None for a coordinate that is not proportional to a single dof.
    Coordinates are turns, slides, and the cone angles of balls. Couplings are fitted at poses less than half
    a turn away from the saved pose; `size` [m] is the scale of slides.
    """
    poses = _poses_around(driver, size)
    driver_changes = np.array([changes(driver, pose) for pose in poses])
    follower_changes = np.array(
        [changes(follower, pose if follower.bodies == driver.bodies else inverse(pose)) for pose in poses]
    )
    reach = np.abs(driver_changes).max(axis=0)
    couplings: list[CoordinateCoupling | None] = []
    for dof, column in zip(follower.dofs, follower_changes.T, strict=True):
        tolerance = ANGLE_TOLERANCE * (size if dof.kind == "slide" else 1.0)
        factors = np.linalg.lstsq(driver_changes, column, rcond=None)[0]
        driving_dofs = np.flatnonzero(np.abs(factors) * reach > tolerance)
        if np.abs(driver_changes @ factors - column).max() > tolerance or len(driving_dofs) > 1:
            couplings.append(None)
        elif len(driving_dofs) == 0:
            couplings.append(CoordinateCoupling(0, 0.0))
        else:
            couplings.append(
                CoordinateCoupling(int(driving_dofs[0]), round(float(factors[driving_dofs[0]]), 12))
            )
    return tuple(couplings)


def _poses_around(view: MateView, size: float) -> list[Array]:
    """Returns displacements (4, 4, in the world) of the first body against the second, as the mate allows
    them."""
    rng = np.random.default_rng(0)
    displacements = []
    back = inverse(chain(view.dofs, view.saved))
    for _ in range(_SAMPLES):
        values = [
            _value_near(value, rng.uniform(-1.0, 1.0, 4), size if dof.kind == "slide" else 1.0)
            for dof, value in zip(view.dofs, view.saved, strict=True)
        ]
        displaced_pose = chain(view.dofs, values) @ back
        displacements.append(view.second @ displaced_pose @ inverse(view.second))
    return displacements


def _value_near(value: Value, step: Array, unit: float) -> Value:
    if not isinstance(value, tuple):
        return value + float(step[0]) * unit
    # Beside the scalar part 2, a vector part of entries up to 1 gives a turn of less than a right angle.
    rotation = rotation_from_quat(np.array(value)) @ rotation_from_quat(np.array([2.0, *step[1:]]))
    return tuple(float(number) for number in quat_from_rotation(rotation))


def changes(view: MateView, displacement: Array) -> Array:
    """Returns the changes (n,) of a mate's coordinates as its first body is displaced relative to its
    second."""
    saved = coordinates(view, np.eye(4))
    displaced = coordinates(view, displacement)
    is_turn = np.array([dof.kind == "turn" for dof in view.dofs])
    change = displaced - saved
    return np.where(is_turn, np.remainder(change + math.pi, math.tau) - math.pi, change)


def coordinates(view: MateView, displacement: Array) -> Array:
    """Returns the turns [rad], slides [m] and cone angles [rad] (n,) with the first body displaced (4, 4)."""
    relative = inverse(view.second) @ displacement @ view.first
    return np.array([
        math.atan2(math.hypot(relative[0, 2], relative[1, 2]), relative[2, 2])
        if dof.kind == "ball" else value_in(relative, dof.kind, dof.axis)
        for dof in view.dofs
    ])  # fmt: skip


def coupled_limits(limits: Limits, value: float, coupling: CoordinateCoupling, dof_value: float) -> Limits:
    """Converts limits of a coordinate, whose value is `value`, to limits of the dof that it is coupled to,
    whose value is `dof_value`."""
    offset = value - coupling.factor * dof_value
    offset = 0.0 if abs(offset) < OFFSET_TOLERANCE else offset
    return limits.mapped(1 / coupling.factor, -offset / coupling.factor)
