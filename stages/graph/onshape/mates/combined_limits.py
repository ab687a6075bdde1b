"""Converts the limits of mates that another mate replaces to limits of that mate."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from linkwright.stages.graph.onshape.assembly import Mate
from linkwright.stages.graph.onshape.mates.coordinates import Tie, carried, coordinates
from linkwright.stages.graph.onshape.mates.joints import freedoms_of, limit_names
from linkwright.stages.graph.onshape.mates.twists import View
from linkwright.stages.robot.model.dofs import LimitOrigin
from linkwright.stages.robot.model.robot import Dof, Limits

MET = 1e-6
"""Mates that the saved pose misses by more [m or rad] are not combined: nothing follows from it."""


class LimitLost(Exception):
    """A limit has no counterpart on the remaining mate; the text gives the reason."""


def narrowed(limits: Sequence[Limits], into: View, tie: Tie | None, dof: Dof, here: float) -> list[Limits]:
    """The `limits` of a mate's dofs, narrowed by those of a dof that is at `here` and that `tie` leads to one
    of them; LimitLost where they cannot be."""
    if dof.limits == Limits():
        return list(limits)
    here = dof.limits.unwrap(here, MET) if dof.kind == "turn" else here
    if tie is None or (tie.factor < 0 and into.dofs[tie.onto].kind == "ball"):
        raise LimitLost("the joint has no matching coordinate")
    if not tie.factor:
        if not dof.limits.contains(here, MET):
            raise LimitLost(f"its value is fixed at {here:.6g}, outside of them")
        return list(limits)
    before = limits[tie.onto]
    there = float(coordinates(into, np.eye(4))[tie.onto])
    there = before.unwrap(there, MET) if into.dofs[tie.onto].kind == "turn" else there
    both = _intersection(before, carried(dof.limits, here, tie, there))
    low, high = both.interval
    if low > high:
        raise LimitLost("no value is within all limits")
    return [both if number == tie.onto else one for number, one in enumerate(limits)]


def _intersection(one: Limits, other: Limits) -> Limits:
    lower = [end for end in (one.lower, other.lower) if end is not None]
    upper = [end for end in (one.upper, other.upper) if end is not None]
    return Limits(max(lower, default=None), min(upper, default=None))


def limited(into: View, limits: Sequence[Limits], origin: LimitOrigin) -> Mate:
    """The mate with these limits of its dofs, and where they come from."""
    drawn = dict(into.mate.limits or {})
    for freedom, own in zip(freedoms_of(into.mate.ref.type), limits, strict=True):
        for name, end in zip(limit_names(freedom), (own.lower, own.upper), strict=True):
            if name and end is not None:
                drawn[name] = end
    mate = replace(into.mate, limits=drawn) if drawn else into.mate
    return mate if mate.limit_origin == origin else replace(mate, limit_origin=origin)
