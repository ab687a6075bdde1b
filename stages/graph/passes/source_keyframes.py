"""Keyframes of the source, in the present values of the joints, with what a file rounds made exact."""

from collections.abc import Mapping, Sequence
from itertools import chain

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, Keyframe, Robot
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loop_groups import LoopGroups
from linkwright.stages.robot.motion.loops import across, closing
from linkwright.stages.robot.motion.start_pose import SAVED, nearest, nearest_closed, open_loops, saved
from linkwright.stages.robot.text.globs import as_key, fits, listed

ROUNDED = 1e-3
"""How far [rad or m] a typed value may be from a limit, from what a relation makes of its driver and from the
pose that closes a loop: files round numbers to three digits."""


def source_values(
    robot: Robot,
    keyframes: Sequence[Keyframe],
    wanted: Mapping[str, Mapping[str, float]],
    log: Diagnostics,
) -> dict[str, dict[str, float]]:
    """Name → dof → value [rad or m] of the source's `keyframes`.

    A value that the user's own of the same name replaces (`wanted`: name → glob → value) is left out, and so
    are those of the joints that a loop or relation makes follow it, and those of followers whose driver has
    one. A value outside the limits is the limit: W-KEYFRAME, but for what is rounding. I-KEYFRAME for a
    follower's value that is not what its driver makes it, and for a keyframe with the name of the saved pose,
    which it does not equal.
    """
    limits = ranges(robot)
    scalars = {dof.name: dof for dof in robot.dofs if dof.kind in ("turn", "slide")}
    groups = _coupled(robot) if keyframes and wanted else []
    found: dict[str, dict[str, float]] = {}
    for one in keyframes:
        typed = {name: scalars[name].in_mate.inverse(value) for name, value in one.given if name in scalars}
        values = {name: _within(value, *limits[name]) for name, value in typed.items()}
        if one.name == SAVED:
            _check_saved(robot, typed, log)
            continue
        values = _closed(robot, _driving(robot, one.name, values, log))
        given = {name for name in scalars if any(fits(name, glob) for glob in wanted.get(one.name, ()))}
        coupled = set(chain.from_iterable(group for group in groups if group & given))
        found[one.name] = {name: value for name, value in values.items() if name not in given | coupled}
        _report_moved(one.name, {name: scalars[name] for name in found[one.name]}, typed, limits, log)
    return found


def _within(value: float, low: float, high: float) -> float:
    """The value; the limit where it is beyond that."""
    return min(max(value, low), high)


def _report_moved(
    keyframe: str,
    dofs: Mapping[str, Dof],
    typed: Mapping[str, float],
    limits: Mapping[str, tuple[float, float]],
    log: Diagnostics,
) -> None:
    """W-KEYFRAME where the source has dofs of a keyframe outside their limits."""
    outside = [
        f"{name} ({typed[name]:g}, now {limit:.6g} {'rad' if dof.kind == 'turn' else 'm'})"
        for name, dof in dofs.items()
        if abs((limit := _within(typed[name], *limits[name])) - typed[name]) > ROUNDED
    ]
    if outside:
        text = f"the source's keyframe is outside the limits of {listed(outside)}: it has the limits there"
        hint = "set limits in `joints`, or leave the keyframe out: "
        log.report("W-KEYFRAME", text, keyframe, f"{hint}`keyframes: {{{as_key(keyframe)}: null}}`")


def _driving(robot: Robot, keyframe: str, values: Mapping[str, float], log: Diagnostics) -> dict[str, float]:
    """The values without those of followers whose drivers have one."""
    found = dict(values)
    for one in robot.relations:
        if one.driver not in values or one.follower not in values:
            continue
        value, made = found.pop(one.follower), one.multiplier * values[one.driver] + one.offset
        if abs(made - value) > ROUNDED:
            text = f"the source's keyframe: {one.driver} = {values[one.driver]:g} makes {one.follower} "
            text += f"{made:g}, not {value:g}"
            log.report("I-KEYFRAME", text, keyframe, f"{one.follower} follows {one.driver}")
    return found


def _closed(robot: Robot, values: Mapping[str, float]) -> dict[str, float]:
    """The values by which the loops close, where these do so but for rounding."""
    near = saved(robot)
    if not robot.loops or not open_loops(robot, nearest(robot, near, values)):
        return dict(values)
    followers = {one.follower: one for one in robot.relations}
    near |= values
    near |= {
        name: one.multiplier * values[one.driver] + one.offset
        for name, one in followers.items()
        if one.driver in values
    }
    poses = link_poses(robot, near)
    for loop in robot.loops:
        near |= closing(loop, across(loop, poses))
    pose = nearest_closed(robot, near, near, {})
    if open_loops(robot, pose):
        return dict(values)
    snapped = {name: float(value) for name in values if not isinstance(value := pose[name], tuple)}
    near_enough = all(abs(value - values[name]) <= ROUNDED for name, value in snapped.items())
    return snapped if near_enough else dict(values)


def _coupled(robot: Robot) -> list[set[str]]:
    """Groups of dofs of which one moves the others: by a loop, or by a relation."""
    groups = LoopGroups(robot)
    together = [groups.moved_by(loop) for loop in robot.loops]
    together += [{one.driver, one.follower} for one in robot.relations]
    found: list[set[str]] = []
    for names in together:
        touching = [group for group in found if group & names]
        found = [group for group in found if not group & names]
        found.append(set(names).union(*touching))
    return found


def _check_saved(robot: Robot, values: Mapping[str, float], log: Diagnostics) -> None:
    at = saved(robot)
    moved = [name for name, value in values.items() if not _same(at[name], value)]
    if moved:
        text = (
            f"the source's keyframe {SAVED} is left out: it moves {listed(moved)}, and {SAVED} is the pose "
        )
        text += "that the source starts in"
        log.report("I-KEYFRAME", text, SAVED, "call it otherwise in the source, or give it in `keyframes`")


def _same(one: object, other: float) -> bool:
    return isinstance(one, float) and abs(one - other) <= ROUNDED
