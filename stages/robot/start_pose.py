"""Named poses of a robot: `saved`, `home`, and the one where a fresh simulation starts."""

from stages.robot.dof_ranges import ranges
from stages.robot.kinematics import link_poses, saved_configuration
from stages.robot.loops import CLOSED, across, closing, gap
from stages.robot.model import Configuration, Robot, Value
from stages.robot.poses import at_rest

_ROUNDING = 1e-12
"""A value that is outside its limits by less, or by that share of it, is within them."""


def starting_point(robot: Robot) -> Configuration:
    """qpos0: mate zero if every loop and relation holds there, else the saved pose.

    Values of the tree's dofs and of the loops' own. A free joint has no mate, and so no zero: it starts at
    its saved pose.
    """
    zero = {dof.name: dof.saved if dof.kind == "free" else at_rest(dof.kind) for dof in robot.dofs}
    holds = all(abs(relation.offset) == 0.0 for relation in robot.relations)
    poses = link_poses(robot, zero)
    if holds and all(gap(loop, poses) <= CLOSED for loop in robot.loops):
        for loop in robot.loops:
            zero |= closing(loop, across(loop, poses))
        return zero
    return saved(robot)


def saved(robot: Robot) -> dict[str, Value]:
    """Values of the pose that was saved in CAD: the tree's dofs and the loops' own."""
    return {
        **saved_configuration(robot),
        **{dof.name: dof.saved for loop in robot.loops for dof in loop.dofs},
    }


def home(robot: Robot, given: Configuration | None = None) -> dict[str, Value]:
    """The pose nearest to the saved one that is within the limits, follows the relations and closes the
    loops; `given` values, by dof, are taken as they are.

    Nearest by the sum of squares [rad, m] over the dofs of the loops, and by itself for each other driver.
    A ball stays as it was saved. Where no such pose closes the loops, they stay open.
    """
    given = given or {}
    near, limits = {**saved(robot), **given}, ranges(robot)
    if not given and all(_within(limits[name], value) for name, value in near.items() if name in limits):
        return near
    start = {
        name: value if name in given or isinstance(value, tuple) else _clipped(limits[name], value)
        for name, value in near.items()
    }
    for one in robot.relations:
        driver = start[one.driver]
        if one.follower not in given and not isinstance(driver, tuple):
            start[one.follower] = one.multiplier * driver + one.offset
    return _closed(robot, start, near, given) if robot.loops else start


def _closed(
    robot: Robot, start: Configuration, near: Configuration, given: Configuration
) -> dict[str, Value]:
    """The configuration with closed loops that is nearest to `near`; `start` where there is none."""
    from stages.robot.closing import Closer
    from stages.robot.pose_batch import repeated

    closer = Closer(robot, held=given)
    values = closer.nearest(repeated(start, 1), repeated(near, 1))
    values, closed = closer.settled(values)
    if not closed[0]:
        return dict(start)
    return {
        name: value[0].tolist() if value.ndim == 1 else tuple(value[0].tolist())
        for name, value in values.items()
    }


def _within(limits: tuple[float, float], value: Value) -> bool:
    if isinstance(value, tuple):
        return True
    rounding = _ROUNDING * max(1.0, abs(value))
    return limits[0] - rounding <= value <= limits[1] + rounding


def _clipped(limits: tuple[float, float], value: float) -> float:
    return min(max(value, limits[0]), limits[1])
