"""The values that dofs may have: their own limits, and by the relations those of others."""

import math

from linkwright.stages.robot.model.robot import Relation, Robot


def ranges(robot: Robot) -> dict[str, tuple[float, float]]:
    """By dof, of the tree and of the loops: (lowest, highest) [rad or m] of each turn and slide; an open end
    is infinite.

    A driver's range is where its own limits and those of all its followers hold, and a follower's follows
    from its driver's. Where the limits exclude each other, the driver's own hold, and it has one value.
    """
    dofs = [*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs)]
    found = {dof.name: dof.limits.interval for dof in dofs if dof.kind in ("turn", "slide")}
    own = dict(found)
    for one in robot.relations:
        low, high = found[one.driver]
        least, most = _driver_range(one, own[one.follower])
        found[one.driver] = max(low, least), min(high, most)
    for driver in {one.driver for one in robot.relations}:
        low, high = found[driver]
        if low > high:
            value = min(max((low + high) / 2, own[driver][0]), own[driver][1])
            found[driver] = value, value
    for one in robot.relations:
        ends = sorted(_times(one.multiplier, end) + one.offset for end in found[one.driver])
        found[one.follower] = ends[0], ends[1]
    return found


def _driver_range(relation: Relation, follower: tuple[float, float]) -> tuple[float, float]:
    """The driver's values at which the follower is within its limits."""
    if relation.multiplier == 0.0:
        return -math.inf, math.inf
    ends = sorted((end - relation.offset) / relation.multiplier for end in follower)
    return ends[0], ends[1]


def _times(factor: float, end: float) -> float:
    return 0.0 if factor == 0.0 else factor * end
