"""Named poses of a robot: `saved`, `home`, the user's, and the one where a fresh simulation starts."""

import functools
from collections.abc import Mapping

import numpy as np

from linkwright.stages.robot.model.poses import at_rest, from_parts, rotation_from_quat
from linkwright.stages.robot.model.robot import Array, Configuration, Robot, Value
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from linkwright.stages.robot.motion.loops import CLOSED, across, closing, gap
from linkwright.stages.robot.motion.pose_batch import repeated

_ROUNDING = 1e-12
"""A value that is outside its limits by less, or by that share of it, is within them."""

HOME, SAVED = "home", "cad"
"""The keyframes that every robot has."""


def starting_point(robot: Robot) -> Configuration:
    """qpos0: mate zero if every loop and relation holds there, else the saved pose; but `home` where that
    pose is outside the limits and `home` closes the loops.

    Values of the tree's dofs and of the loops' own. A free joint has no mate, and so no zero: it starts at
    its saved pose. The saved pose of an MJCF source is its qpos0: it stays that.
    """
    if robot.mjcf is not None:
        return saved(robot)
    start = _closed_at_zero(robot) or saved(robot)
    if is_within(robot, start):
        return start
    instead = home(robot)
    return instead if is_within(robot, instead) and not open_loops(robot, instead) else start


def _closed_at_zero(robot: Robot) -> dict[str, Value] | None:
    """Mate zero, if every loop and relation holds there."""
    zero = {dof.name: dof.saved if dof.kind == "free" else at_rest(dof.kind) for dof in robot.dofs}
    holds = all(abs(relation.offset) == 0.0 for relation in robot.relations)
    poses = link_poses(robot, zero)
    if not holds or any(gap(loop, poses) > CLOSED for loop in robot.loops):
        return None
    for loop in robot.loops:
        zero |= closing(loop, across(loop, poses))
    return zero


def saved(robot: Robot) -> dict[str, Value]:
    """Values of the pose that was saved in CAD: the tree's dofs and the loops' own."""
    return {
        **saved_configuration(robot),
        **{dof.name: dof.saved for loop in robot.loops for dof in loop.dofs},
    }


def home(robot: Robot) -> dict[str, Value]:
    """The pose nearest to the saved one that has the values of the keyframe `home`, if the user gives it."""
    return dict(_home(robot))


@functools.lru_cache(maxsize=4)  # asked for in many places of a stage, of one and the same robot
def _home(robot: Robot) -> Configuration:
    return nearest(robot, saved(robot), _given(robot).get(HOME, {}))


def keyframes(robot: Robot) -> dict[str, dict[str, Value]]:
    """Every named pose: `home`, the saved one as `cad`, and the user's own, each the nearest to `home` that
    has its values."""
    at_home = home(robot)
    own = {name: given for name, given in _given(robot).items() if name != HOME}
    found = {name: nearest(robot, at_home, given) for name, given in own.items()}
    return {HOME: at_home, SAVED: saved(robot), **found}


def roots_in_source(robot: Robot) -> dict[str, Array]:
    """World from root (4, 4) in the robot's source: by keyframe of an MJCF, and elsewhere under ""."""
    poses = {"": robot.world_from_root}
    if robot.mjcf is not None and not robot.base.fixed:
        for one in robot.mjcf.keyframes:
            if one.world_from_root:
                x, y, z, *quat = one.world_from_root
                poses[one.name] = from_parts(rotation_from_quat(np.array(quat)), np.array([x, y, z]))
    return poses


def _given(robot: Robot) -> dict[str, dict[str, float]]:
    return {keyframe.name: dict(keyframe.given) for keyframe in robot.keyframes}


def nearest(robot: Robot, near: Configuration, given: Mapping[str, float] | None = None) -> dict[str, Value]:
    """The pose nearest to `near` that is within the limits, follows the relations and closes the loops;
    `given` values, by dof, are taken as they are.

    Nearest by the sum of squares over the dofs of the loops, each as a share of its range (see
    `Closer.nearest`), and by itself for each other driver. A ball stays as it is in `near`. Where no such
    pose closes the loops, they stay open.
    """
    given = given or {}
    near = {**near, **given}
    if not given and is_within(robot, near):
        return near
    limits = ranges(robot)
    start = {
        name: value if name in given or isinstance(value, tuple) else _clipped(limits[name], value)
        for name, value in near.items()
    }
    for one in robot.relations:
        driver = start[one.driver]
        if one.follower not in given and not isinstance(driver, tuple):
            start[one.follower] = one.multiplier * driver + one.offset
    return nearest_closed(robot, start, near, given) if robot.loops else start


def nearest_closed(
    robot: Robot, start: Configuration, near: Configuration, given: Mapping[str, float]
) -> dict[str, Value]:
    """The configuration with closed loops that is nearest to `near`; `start` where there is none."""
    closer = Closer(robot, held=given)
    values = closer.nearest(repeated(start, 1), repeated(near, 1))
    values, closed = closer.settled(values)
    if not closed[0]:
        return dict(start)
    return {
        name: value[0].tolist() if value.ndim == 1 else tuple(value[0].tolist())
        for name, value in values.items()
    }


def is_within(robot: Robot, values: Configuration) -> bool:
    """Whether every turn and slide is within its limits, and those of what follows it."""
    limits = ranges(robot)
    return all(_within(limits[name], value) for name, value in values.items() if name in limits)


def open_loops(robot: Robot, values: Configuration) -> list[str]:
    """The names of the loops that are further from closed than in the saved pose."""
    if not robot.loops:
        return []
    poses = link_poses(robot, values)
    return [loop.name for loop in robot.loops if gap(loop, poses) > max(CLOSED, 2 * loop.residual)]


def _within(limits: tuple[float, float], value: Value) -> bool:
    if isinstance(value, tuple):
        return True
    rounding = _ROUNDING * max(1.0, abs(value))
    return limits[0] - rounding <= value <= limits[1] + rounding


def _clipped(limits: tuple[float, float], value: float) -> float:
    return min(max(value, limits[0]), limits[1])
