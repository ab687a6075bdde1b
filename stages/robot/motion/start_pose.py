"""Computes the named poses of a robot: `saved`, `home`, the user's, and the start of a fresh simulation."""

import functools
from collections.abc import Mapping

import numpy as np

from linkwright.stages.robot.model.poses import at_rest, from_parts, rotation_from_quat
from linkwright.stages.robot.model.robot import Array, Configuration, Robot, Value
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from linkwright.stages.robot.motion.loops import MAX_CLOSED_GAP, closing_values, gap, relative_pose
from linkwright.stages.robot.motion.pose_batch import repeated

_LIMIT_TOLERANCE = 1e-12
"""Largest excess of a value over its limits that counts as rounding [rad or m]; for values above 1, as a
share of the value."""

HOME, SAVED = "home", "cad"
"""Names of the keyframes that every robot has."""


def starting_point(robot: Robot) -> Configuration:
    """Returns the pose in which a simulation starts (MuJoCo's qpos0), as values of the dofs of tree and
    loops.

    It is mate zero, with all values 0, if every loop and relation holds there, else the saved pose. If this
    pose is outside the limits, it is `home` instead, provided that `home` is within them and closes the
    loops. A free joint has no mate and keeps its saved pose. An MJCF source keeps its own qpos0, which is its
    saved pose.
    """
    if robot.mjcf is not None:
        return saved(robot)
    start = _closed_at_zero(robot) or saved(robot)
    if is_within(robot, start):
        return start
    at_home = home(robot)
    return at_home if is_within(robot, at_home) and not open_loops(robot, at_home) else start


def _closed_at_zero(robot: Robot) -> dict[str, Value] | None:
    """Returns mate zero, with the values of the loops' dofs; None if a loop or relation does not hold
    there."""
    zero = {dof.name: dof.saved if dof.kind == "free" else at_rest(dof.kind) for dof in robot.dofs}
    relations_hold = all(relation.offset == 0.0 for relation in robot.relations)
    poses = link_poses(robot, zero)
    if not relations_hold or any(gap(loop, poses) > MAX_CLOSED_GAP for loop in robot.loops):
        return None
    for loop in robot.loops:
        zero |= closing_values(loop, relative_pose(loop, poses))
    return zero


def saved(robot: Robot) -> dict[str, Value]:
    """Returns the saved pose, as values of the dofs of tree and loops."""
    return {
        **saved_configuration(robot),
        **{dof.name: dof.saved for loop in robot.loops for dof in loop.dofs},
    }


def home(robot: Robot) -> dict[str, Value]:
    """Returns the pose nearest to the saved pose that has the values of the user's keyframe `home`, if there
    is one. See `nearest`."""
    return dict(_home(robot))


@functools.lru_cache(maxsize=4)  # a stage asks many times for the `home` of the same robot
def _home(robot: Robot) -> Configuration:
    return nearest(robot, saved(robot), _keyframe_values(robot).get(HOME, {}))


def keyframes(robot: Robot) -> dict[str, dict[str, Value]]:
    """Returns all named poses: `home`, the saved pose as `cad`, and the user's own. Each of these is the pose
    nearest to `home` that has its values."""
    at_home = home(robot)
    user_values = {name: pose_values for name, pose_values in _keyframe_values(robot).items() if name != HOME}
    user_poses = {name: nearest(robot, at_home, pose_values) for name, pose_values in user_values.items()}
    return {HOME: at_home, SAVED: saved(robot), **user_poses}


def roots_in_source(robot: Robot) -> dict[str, Array]:
    """Returns world_from_root (4, 4) in the robot's source: at the saved pose under "", and for a floating
    root at each keyframe of an MJCF that has its pose."""
    poses = {"": robot.world_from_root}
    if robot.mjcf is not None and not robot.base.fixed:
        for keyframe in robot.mjcf.keyframes:
            if keyframe.world_from_root:
                x, y, z, *quat = keyframe.world_from_root
                poses[keyframe.name] = from_parts(rotation_from_quat(np.array(quat)), np.array([x, y, z]))
    return poses


def _keyframe_values(robot: Robot) -> dict[str, dict[str, float]]:
    """Returns the user's keyframes: name → dof → value."""
    return {keyframe.name: dict(keyframe.given) for keyframe in robot.keyframes}


def nearest(
    robot: Robot, target: Configuration, fixed_values: Mapping[str, float] | None = None
) -> dict[str, Value]:
    """Returns the pose nearest to `target` that is within the limits, satisfies the relations and closes the
    loops. Dofs in `fixed_values` have these values, whatever the limits and relations are.

    For dofs of loops the distance is that of `Closer.nearest`; each other driver is moved into its limits on
    its own. A ball outside of loops keeps its value in `target`. If the loops cannot be closed, they stay
    open.
    """
    fixed_values = fixed_values or {}
    target = {**target, **fixed_values}
    if not fixed_values and is_within(robot, target):
        return target
    limits = ranges(robot)
    start = {
        name: value if name in fixed_values or isinstance(value, tuple) else _clipped(limits[name], value)
        for name, value in target.items()
    }
    for relation in robot.relations:
        driver = start[relation.driver]
        if relation.follower not in fixed_values and not isinstance(driver, tuple):
            start[relation.follower] = relation.multiplier * driver + relation.offset
    return nearest_closed(robot, start, target, fixed_values) if robot.loops else start


def nearest_closed(
    robot: Robot, start: Configuration, target: Configuration, fixed_values: Mapping[str, float]
) -> dict[str, Value]:
    """Returns the configuration with closed loops that is nearest to `target`, reached from `start`; `start`
    itself if the loops cannot be closed. Dofs in `fixed_values` are not moved."""
    closer = Closer(robot, held=fixed_values)
    values = closer.nearest(repeated(start, 1), repeated(target, 1))
    values, closed = closer.settled(values)
    if not closed[0]:
        return dict(start)
    return {
        name: value[0].tolist() if value.ndim == 1 else tuple(value[0].tolist())
        for name, value in values.items()
    }


def is_within(robot: Robot, values: Configuration) -> bool:
    """Returns whether the value of every turn and slide is within its range (see `ranges`)."""
    limits = ranges(robot)
    return all(_is_inside(limits[name], value) for name, value in values.items() if name in limits)


def open_loops(robot: Robot, values: Configuration) -> list[str]:
    """Returns the names of the loops that are open. A loop that is open in the saved pose may have twice that
    gap."""
    if not robot.loops:
        return []
    poses = link_poses(robot, values)
    return [loop.name for loop in robot.loops if gap(loop, poses) > max(MAX_CLOSED_GAP, 2 * loop.residual)]


def _is_inside(limits: tuple[float, float], value: Value) -> bool:
    if isinstance(value, tuple):
        return True
    rounding = _LIMIT_TOLERANCE * max(1.0, abs(value))
    return limits[0] - rounding <= value <= limits[1] + rounding


def _clipped(limits: tuple[float, float], value: float) -> float:
    return min(max(value, limits[0]), limits[1])
