"""Converts the limits of a mate that another mate replaces to limits of the remaining mate."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from linkwright.stages.graph.onshape.assembly import Mate
from linkwright.stages.graph.onshape.mates.coordinates import CoordinateCoupling, coordinates, coupled_limits
from linkwright.stages.graph.onshape.mates.joints import freedoms_of, limit_names
from linkwright.stages.graph.onshape.mates.twists import MateView
from linkwright.stages.robot.model.dofs import LimitOrigin
from linkwright.stages.robot.model.robot import Dof, Limits

POSE_TOLERANCE = 1e-6
"""Largest error [m or rad] at the saved pose of mates that are combined: mates that contradict each other
more cannot be."""


class LimitLost(Exception):
    """An error of a limit that has no counterpart on the remaining mate; the text gives the reason."""


def narrow_limits(
    limits: Sequence[Limits], remaining: MateView, coupling: CoordinateCoupling | None, dof: Dof, value: float
) -> list[Limits]:
    """Returns the limits of the dofs of the mate `remaining`, narrowed by those of a dof of another mate;
    raises LimitLost if that is not possible.
    `limits`: limits of the dofs of `remaining`; `dof`, `value`: the dof of the other mate, and its value at
    the saved pose; `coupling`: the coupling of `dof` to a dof of `remaining`.
    """
    if dof.limits == Limits():
        return list(limits)
    value = dof.limits.unwrap(value, POSE_TOLERANCE) if dof.kind == "turn" else value
    if coupling is None or (coupling.factor < 0 and remaining.dofs[coupling.dof_index].kind == "ball"):
        raise LimitLost("the joint has no matching coordinate")
    if not coupling.factor:
        if not dof.limits.contains(value, POSE_TOLERANCE):
            raise LimitLost(f"its value is fixed at {value:.6g}, outside of them")
        return list(limits)
    previous = limits[coupling.dof_index]
    target_value = float(coordinates(remaining, np.eye(4))[coupling.dof_index])
    target_value = (
        previous.unwrap(target_value, POSE_TOLERANCE)
        if remaining.dofs[coupling.dof_index].kind == "turn"
        else target_value
    )
    common = _intersection(previous, coupled_limits(dof.limits, value, coupling, target_value))
    low, high = common.interval
    if low > high:
        raise LimitLost("no value is within all limits")
    return [common if number == coupling.dof_index else limit for number, limit in enumerate(limits)]


def _intersection(first: Limits, second: Limits) -> Limits:
    lower = [end for end in (first.lower, second.lower) if end is not None]
    upper = [end for end in (first.upper, second.upper) if end is not None]
    return Limits(max(lower, default=None), min(upper, default=None))


def with_dof_limits(remaining: MateView, limits: Sequence[Limits], origin: LimitOrigin) -> Mate:
    """Returns the mate with these limits of its dofs, and where they come from."""
    limit_values = dict(remaining.mate.limits or {})
    for freedom, limit in zip(freedoms_of(remaining.mate.ref.type), limits, strict=True):
        for name, end in zip(limit_names(freedom), (limit.lower, limit.upper), strict=True):
            if name and end is not None:
                limit_values[name] = end
    mate = replace(remaining.mate, limits=limit_values) if limit_values else remaining.mate
    return mate if mate.limit_origin == origin else replace(mate, limit_origin=origin)
