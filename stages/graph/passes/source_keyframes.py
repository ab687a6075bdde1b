"""Converts the source's keyframes to the robot's joint values, and makes rounded values exact."""

from collections.abc import Mapping, Sequence
from itertools import chain

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, Keyframe, Robot
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loop_groups import LoopGroups
from linkwright.stages.robot.motion.loops import closing_values, relative_pose
from linkwright.stages.robot.motion.start_pose import SAVED, nearest, nearest_closed, open_loops, saved
from linkwright.stages.robot.text.globs import matches_glob, name_list, yaml_key

ROUNDING_TOLERANCE = 1e-3
"""Largest rounding [rad or m] of a typed value: its distance from a limit, from the value that a relation
gives it, and from the pose that closes a loop. Files round numbers to three digits."""


def source_values(
    robot: Robot,
    keyframes: Sequence[Keyframe],
    user_keyframes: Mapping[str, Mapping[str, float]],
    log: Diagnostics,
) -> dict[str, dict[str, float]]:
    """Returns the values [rad or m] of the source's `keyframes`, by name and by dof.
    Three kinds of values are left out: those that the user's keyframe of the same name replaces
    (`user_keyframes`: name → glob → value), those of joints that a loop or relation couples to such joints,
    and those of followers whose driver has a value. A value outside the limits becomes the limit: W-KEYFRAME,
    unless the difference is rounding. Reports I-KEYFRAME for a follower's value that contradicts its
    driver's, and for a keyframe that has the name of the saved pose but differs from it.
    """
    limits = ranges(robot)
    scalars = {dof.name: dof for dof in robot.dofs if dof.kind in ("turn", "slide")}
    groups = _coupled_groups(robot) if keyframes and user_keyframes else []
    values_by_name: dict[str, dict[str, float]] = {}
    for keyframe in keyframes:
        keyframe_values = {
            name: scalars[name].mate_value.from_mate(value)
            for name, value in keyframe.given
            if name in scalars
        }
        values = {name: _clip(value, *limits[name]) for name, value in keyframe_values.items()}
        if keyframe.name == SAVED:
            _check_saved(robot, keyframe_values, log)
            continue
        values = _closed_values(robot, _driver_values(robot, keyframe.name, values, log))
        replaced_dofs = {
            name
            for name in scalars
            if any(matches_glob(name, glob) for glob in user_keyframes.get(keyframe.name, ()))
        }
        coupled_dofs = set(chain.from_iterable(group for group in groups if group & replaced_dofs))
        values_by_name[keyframe.name] = {
            name: value for name, value in values.items() if name not in replaced_dofs | coupled_dofs
        }
        _report_clipped(
            keyframe.name,
            {name: scalars[name] for name in values_by_name[keyframe.name]},
            keyframe_values,
            limits,
            log,
        )
    return values_by_name


def _clip(value: float, low: float, high: float) -> float:
    """Returns the value, or the limit that it exceeds."""
    return min(max(value, low), high)


def _report_clipped(
    keyframe: str,
    dofs: Mapping[str, Dof],
    values: Mapping[str, float],
    limits: Mapping[str, tuple[float, float]],
    log: Diagnostics,
) -> None:
    """Reports W-KEYFRAME for dofs of the source's keyframe that were outside their limits by more than
    rounding."""
    misfits = [
        f"{name} ({values[name]:g}, now {limit:.6g} {'rad' if dof.kind == 'turn' else 'm'})"
        for name, dof in dofs.items()
        if abs((limit := _clip(values[name], *limits[name])) - values[name]) > ROUNDING_TOLERANCE
    ]
    if misfits:
        text = f"the source's keyframe is outside the limits of {name_list(misfits)}: it has the limits there"
        hint = "set limits in `joints`, or leave the keyframe out: "
        log.report("W-KEYFRAME", text, keyframe, f"{hint}`keyframes: {{{yaml_key(keyframe)}: null}}`")


def _driver_values(
    robot: Robot, keyframe: str, values: Mapping[str, float], log: Diagnostics
) -> dict[str, float]:
    """Returns the values without those of followers whose drivers have a value."""
    driver_values = dict(values)
    for relation in robot.relations:
        driver, follower = relation.driver, relation.follower
        if driver not in values or follower not in values:
            continue
        value, value_of_follower = (
            driver_values.pop(follower),
            relation.multiplier * values[driver] + relation.offset,
        )
        if abs(value_of_follower - value) > ROUNDING_TOLERANCE:
            text = f"the source's keyframe: {driver} = {values[driver]:g} makes {follower} "
            text += f"{value_of_follower:g}, not {value:g}"
            log.report("I-KEYFRAME", text, keyframe, f"{follower} follows {driver}")
    return driver_values


def _closed_values(robot: Robot, values: Mapping[str, float]) -> dict[str, float]:
    """Returns values that close the loops exactly, if `values` do so except for rounding; else `values`."""
    saved_pose = saved(robot)
    if not robot.loops or not open_loops(robot, nearest(robot, saved_pose, values)):
        return dict(values)
    followers = {relation.follower: relation for relation in robot.relations}
    saved_pose |= values
    saved_pose |= {
        name: relation.multiplier * values[relation.driver] + relation.offset
        for name, relation in followers.items()
        if relation.driver in values
    }
    poses = link_poses(robot, saved_pose)
    for loop in robot.loops:
        saved_pose |= closing_values(loop, relative_pose(loop, poses))
    pose = nearest_closed(robot, saved_pose, saved_pose, {})
    if open_loops(robot, pose):
        return dict(values)
    snapped = {name: float(value) for name in values if not isinstance(value := pose[name], tuple)}
    near_enough = all(abs(value - values[name]) <= ROUNDING_TOLERANCE for name, value in snapped.items())
    return snapped if near_enough else dict(values)


def _coupled_groups(robot: Robot) -> list[set[str]]:
    """Returns groups of dofs that move together: by a loop, or by a relation."""
    groups = LoopGroups(robot)
    coupled_names = [groups.dofs_of(loop) for loop in robot.loops]
    coupled_names += [{relation.driver, relation.follower} for relation in robot.relations]
    merged: list[set[str]] = []
    for names in coupled_names:
        touching = [group for group in merged if group & names]
        merged = [group for group in merged if not group & names]
        merged.append(set(names).union(*touching))
    return merged


def _check_saved(robot: Robot, values: Mapping[str, float], log: Diagnostics) -> None:
    saved_pose = saved(robot)
    names = [name for name, value in values.items() if not _is_equal(saved_pose[name], value)]
    if names:
        text = f"the source's keyframe {SAVED} is left out: it moves {name_list(names)}, "
        text += f"and {SAVED} is the pose that the source starts in"
        log.report("I-KEYFRAME", text, SAVED, "call it otherwise in the source, or give it in `keyframes`")


def _is_equal(value: object, expected: float) -> bool:
    return isinstance(value, float) and abs(value - expected) <= ROUNDING_TOLERANCE
