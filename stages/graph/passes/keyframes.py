"""Adds the keyframes of the source and of the key `keyframes` to a robot, and checks that loops close."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.passes.source_keyframes import source_values
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, Keyframe, Robot
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.start_pose import HOME, SAVED, home, keyframes, open_loops
from linkwright.stages.robot.quantity_keys import misfit, unit_hint
from linkwright.stages.robot.text.globs import matches_glob, name_list, no_match_hint, yaml_key

LIMIT_TOLERANCE = 1e-9
"""Tolerance [rad or m] by which a value may exceed a limit, for rounding."""


def with_keyframes(
    robot: Robot,
    entries: Mapping[str, Mapping[str, float] | None],
    log: Diagnostics,
    source_keyframes: Sequence[Keyframe] = (),
) -> Robot:
    """Returns the robot with the keyframes of the source and of the configuration (`entries`: name → glob →
    value). If several globs match a dof, the last glob counts; if none matches, the source's value stays.
    None in place of values removes the source's keyframe.

    Reports E-GLOB for a glob that matches no dof; E-KEYFRAME for a dof that is neither a turn nor a slide,
    for a value that is outside its limits or contradicts a relation, for values that leave a loop open, and
    for None if the source has no such keyframe; W-HOME if no pose within the limits closes a loop;
    W-KEYFRAME and I-KEYFRAME as in `source_values`.
    """
    poses = {name: values for name, values in entries.items() if values is not None}
    left_out = entries.keys() - poses.keys()
    _check_left_out(left_out, [keyframe.name for keyframe in source_keyframes], log)
    source_keyframes = [keyframe for keyframe in source_keyframes if keyframe.name not in left_out]
    source_poses = source_values(robot, source_keyframes, poses, log)
    new_keyframes = [
        _keyframe(robot, name, poses.get(name, {}), source_poses.get(name, {}), log)
        for name in dict.fromkeys((*source_poses, *poses))
    ]
    if log.problems:
        return robot
    posed_robot = replace(robot, keyframes=tuple(new_keyframes))
    _check_loops(posed_robot, poses, source_poses, log)
    return posed_robot


def _keyframe(
    robot: Robot, name: str, entries: Mapping[str, float], source_pose: Mapping[str, float], log: Diagnostics
) -> Keyframe:
    """Makes a keyframe of the source's values (`source_pose`, by dof), overridden by the user's (`entries`,
    by glob)."""
    where = f"keyframes.{name}"
    if name == SAVED:
        log.report("E-KEYFRAME", f"{SAVED} is the pose that was saved in CAD", where, "choose another name")
    values = dict(source_pose)
    for glob, value in entries.items():
        dofs = [dof for dof in robot.dofs if matches_glob(dof.name, glob)]
        scalars = [dof for dof in dofs if dof.kind in ("turn", "slide")]
        if not dofs:
            hint = no_match_hint(glob, {"joints": [dof.name for dof in robot.dofs]})
            log.report_unmatched("E-GLOB", f"no joint matches {glob!r}", where, hint, glob)
        elif not scalars:
            text = f"{glob!r} matches only balls or free joints, which have no single value: {dofs[0].name}"
            log.report("E-KEYFRAME", text, where, "leave it out: they stay as they were saved")
        misfits = [(text, dof) for dof in scalars if (text := misfit(value, dof.kind))]
        if misfits:
            text, dof = misfits[0]
            text = f"{glob!r}: {text}, and {dof.name} is a {dof.kind}"
            log.report("E-KEYFRAME", text, where, unit_hint(dof.kind))
        values |= {dof.name: float(value) for dof in scalars}
    _check_limits(robot, values, where, log)
    return Keyframe(name, tuple(_with_drivers(robot, values, where, log).items()))


def _check_left_out(names: Collection[str], source_names: Collection[str], log: Diagnostics) -> None:
    """Reports names to leave out that no keyframe of the source has (E-KEYFRAME)."""
    for name in sorted({*names} - {*source_names}):
        hint = (
            f"the source's keyframes are: {name_list(source_names)}"
            if source_names
            else "the source has none"
        )
        log.report(
            "E-KEYFRAME", f"the source has no keyframe {name!r} to leave out", f"keyframes.{name}", hint
        )


def _check_limits(robot: Robot, values: Mapping[str, float], where: str, log: Diagnostics) -> None:
    limits = ranges(robot)
    for dof in robot.dofs:
        if dof.name not in values:
            continue
        low, high = limits[dof.name]
        if not low - LIMIT_TOLERANCE <= values[dof.name] <= high + LIMIT_TOLERANCE:
            unit = "rad" if dof.kind == "turn" else "m"
            text = f"{values[dof.name]:g} {unit} is outside the limits of {dof.name}, {low:.6g} to {high:.6g}"
            log.report("E-KEYFRAME", text, where, "choose a value within, or set limits in `joints`")


def _with_drivers(
    robot: Robot, values: Mapping[str, float], where: str, log: Diagnostics
) -> dict[str, float]:
    """Returns the values in the order of the dofs, in which a follower's value is replaced by the value of
    its driver that gives it."""
    complete = dict(values)
    for relation in robot.relations:
        driver, follower = relation.driver, relation.follower
        if follower not in values or relation.multiplier == 0.0:
            continue
        driver_value = (values[follower] - relation.offset) / relation.multiplier
        if abs(complete.setdefault(driver, driver_value) - driver_value) > LIMIT_TOLERANCE * max(
            1.0, abs(driver_value)
        ):
            follower_value = relation.multiplier * complete[driver] + relation.offset
            text = f"{driver} = {complete[driver]:g} makes {follower} {follower_value:g}"
            text += f", not {values[follower]:g}"
            log.report("E-KEYFRAME", text, where, f"give {driver} alone: {follower} follows it")
    followers = {relation.follower for relation in robot.relations if relation.multiplier != 0.0}
    driving_dofs: list[Dof] = [
        dof for dof in robot.dofs if dof.name in complete and dof.name not in followers
    ]
    return {dof.name: complete[dof.name] for dof in driving_dofs}


def _check_loops(
    robot: Robot, user_poses: Collection[str], source_poses: Collection[str], log: Diagnostics
) -> None:
    """Reports poses that leave loops open. `user_poses`, `source_poses`: the names of the
    keyframes of the user and of the source."""
    if not robot.loops:
        return
    poses = keyframes(robot) if robot.keyframes else {HOME: home(robot)}
    for name, pose in poses.items():
        still_open = ", ".join(open_loops(robot, pose)) if name != SAVED else ""
        if still_open and (name in user_poses or name in source_poses):
            text = f"no pose with these values closes {still_open}"
            hint = "give fewer joints of the loop: the others follow"
            if name not in user_poses:
                text = f"the source's keyframe: {text}"
                hint = f"give one joint of the loop in `keyframes.{name}`, which the others follow, "
                hint += f"or leave the keyframe out: `keyframes: {{{yaml_key(name)}: null}}`"
            log.report("E-KEYFRAME", text, f"keyframes.{name}", hint)
        elif still_open:
            text = f"no pose within the limits closes this loop, so it starts open at {name}"
            log.report(
                "W-HOME", text, still_open, "widen limits in `joints`, or save the document in another pose"
            )
