"""Computes the ranges of dofs, from their own limits and by the relations from those of other dofs."""

import math

from linkwright.stages.robot.model.robot import Relation, Robot


def ranges(robot: Robot) -> dict[str, tuple[float, float]]:
    """Returns the range (lowest, highest) [rad or m] of each turn and slide of the tree and of the loops; an
    open end is infinite.

    In the range of a driver its own limits and those of all its followers hold; the range of a follower
    results from that of its driver. If the limits exclude each other, the range of the driver is a single
    value within its own limits.
    """
    dofs = [*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs)]
    intervals = {dof.name: dof.limits.interval for dof in dofs if dof.kind in ("turn", "slide")}
    limits = dict(intervals)
    for relation in robot.relations:
        low, high = intervals[relation.driver]
        lowest, highest = _driver_range(relation, limits[relation.follower])
        intervals[relation.driver] = max(low, lowest), min(high, highest)
    for driver in {relation.driver for relation in robot.relations}:
        low, high = intervals[driver]
        if low > high:
            value = min(max((low + high) / 2, limits[driver][0]), limits[driver][1])
            intervals[driver] = value, value
    for relation in robot.relations:
        ends = sorted(
            _times(relation.multiplier, end) + relation.offset for end in intervals[relation.driver]
        )
        intervals[relation.follower] = ends[0], ends[1]
    return intervals


def _driver_range(relation: Relation, follower_limits: tuple[float, float]) -> tuple[float, float]:
    """Returns the lowest and the highest value of the driver at which the follower is within its limits."""
    if relation.multiplier == 0.0:
        return -math.inf, math.inf
    ends = sorted((end - relation.offset) / relation.multiplier for end in follower_limits)
    return ends[0], ends[1]


def _times(factor: float, end: float) -> float:
    # 0 times an open end would be NaN.
    return 0.0 if factor == 0.0 else factor * end
