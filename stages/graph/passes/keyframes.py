"""Poses that the key `keyframes` and the source name, and whether `home` closes the loops."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.passes.source_keyframes import source_values
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, Keyframe, Robot
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.start_pose import HOME, SAVED, home, keyframes, open_loops
from linkwright.stages.robot.quantity_keys import as_typed, misfit
from linkwright.stages.robot.text.globs import as_key, fits, listed, there_are

BEYOND = 1e-9
"""How far [rad or m] a value may lie beyond a limit: the rounding of what was typed."""


def with_keyframes(
    robot: Robot,
    keys: Mapping[str, Mapping[str, float] | None],
    log: Diagnostics,
    of_source: Sequence[Keyframe] = (),
) -> Robot:
    """The robot with the keyframes of the source and the user's: of a dof that several globs match the last
    one counts, and the source's value counts where none does. None in place of values leaves the source's
    keyframe out.

    E-GLOB for a glob that matches no dof; E-KEYFRAME for a value that a dof cannot have: it is no turn or
    slide, the value is beyond its limits, or it contradicts a relation, for values that leave a loop open,
    and for None where the source has no such keyframe. W-HOME where no pose within the limits closes a loop;
    W-KEYFRAME and I-KEYFRAME as in `source_values`.
    """
    wanted = {name: values for name, values in keys.items() if values is not None}
    left_out = keys.keys() - wanted.keys()
    _check_left_out(left_out, [keyframe.name for keyframe in of_source], log)
    of_source = [keyframe for keyframe in of_source if keyframe.name not in left_out]
    before = source_values(robot, of_source, wanted, log)
    made = [
        _keyframe(robot, name, wanted.get(name, {}), before.get(name, {}), log)
        for name in dict.fromkeys((*before, *wanted))
    ]
    if log.problems:
        return robot
    found = replace(robot, keyframes=tuple(made))
    _check_loops(found, wanted, before, log)
    return found


def _keyframe(
    robot: Robot, name: str, wanted: Mapping[str, float], before: Mapping[str, float], log: Diagnostics
) -> Keyframe:
    """`before`: values by dof that the user's do not replace."""
    where = f"keyframes.{name}"
    if name == SAVED:
        log.report("E-KEYFRAME", f"{SAVED} is the pose that was saved in CAD", where, "choose another name")
    given = dict(before)
    for glob, value in wanted.items():
        matched = [dof for dof in robot.dofs if fits(dof.name, glob)]
        scalars = [dof for dof in matched if dof.kind in ("turn", "slide")]
        if not matched:
            hint = there_are(glob, {"joints": [dof.name for dof in robot.dofs]})
            log.unmatched("E-GLOB", f"no joint matches {glob!r}", where, hint, glob)
        elif not scalars:
            text = (
                f"{glob!r} matches only balls or free joints, which have no single value: {matched[0].name}"
            )
            log.report("E-KEYFRAME", text, where, "leave it out: they stay as they were saved")
        wrong = [(text, dof) for dof in scalars if (text := misfit(value, dof.kind))]
        for text, dof in wrong[:1]:
            text = f"{glob!r}: {text}, and {dof.name} is a {dof.kind}"
            log.report("E-KEYFRAME", text, where, as_typed(dof.kind))
        given |= {dof.name: float(value) for dof in scalars}
    _check_limits(robot, given, where, log)
    return Keyframe(name, tuple(_with_drivers(robot, given, where, log).items()))


def _check_left_out(names: Collection[str], of_source: Collection[str], log: Diagnostics) -> None:
    """E-KEYFRAME for names that no keyframe of the source has."""
    for name in sorted({*names} - {*of_source}):
        hint = f"the source's keyframes are: {listed(of_source)}" if of_source else "the source has none"
        log.report(
            "E-KEYFRAME", f"the source has no keyframe {name!r} to leave out", f"keyframes.{name}", hint
        )


def _check_limits(robot: Robot, given: Mapping[str, float], where: str, log: Diagnostics) -> None:
    limits = ranges(robot)
    for dof in robot.dofs:
        if dof.name not in given:
            continue
        low, high = limits[dof.name]
        if not low - BEYOND <= given[dof.name] <= high + BEYOND:
            unit = "rad" if dof.kind == "turn" else "m"
            text = f"{given[dof.name]:g} {unit} is outside the limits of {dof.name}, {low:.6g} to {high:.6g}"
            log.report("E-KEYFRAME", text, where, "choose a value within, or set limits in `joints`")


def _with_drivers(robot: Robot, given: Mapping[str, float], where: str, log: Diagnostics) -> dict[str, float]:
    """The values with those of the drivers of followers among them, in the order of the dofs."""
    found = dict(given)
    for one in robot.relations:
        if one.follower not in given or one.multiplier == 0.0:
            continue
        wanted = (given[one.follower] - one.offset) / one.multiplier
        if abs(found.setdefault(one.driver, wanted) - wanted) > BEYOND * max(1.0, abs(wanted)):
            text = f"{one.driver} = {found[one.driver]:g} makes {one.follower} "
            text += f"{one.multiplier * found[one.driver] + one.offset:g}, not {given[one.follower]:g}"
            log.report("E-KEYFRAME", text, where, f"give {one.driver} alone: {one.follower} follows it")
    followers = {one.follower for one in robot.relations if one.multiplier != 0.0}
    order: list[Dof] = [dof for dof in robot.dofs if dof.name in found and dof.name not in followers]
    return {dof.name: found[dof.name] for dof in order}


def _check_loops(robot: Robot, wanted: Collection[str], before: Collection[str], log: Diagnostics) -> None:
    """`wanted`, `before`: the names of the user's and of the source's keyframes."""
    if not robot.loops:
        return
    poses = keyframes(robot) if robot.keyframes else {HOME: home(robot)}
    for name, pose in poses.items():
        still_open = ", ".join(open_loops(robot, pose)) if name != SAVED else ""
        if still_open and (name in wanted or name in before):
            text = f"no pose with these values closes {still_open}"
            hint = "give fewer joints of the loop: the others follow"
            if name not in wanted:
                text = f"the source's keyframe: {text}"
                hint = f"give one joint of the loop in `keyframes.{name}`, which the others follow, "
                hint += f"or leave the keyframe out: `keyframes: {{{as_key(name)}: null}}`"
            log.report("E-KEYFRAME", text, f"keyframes.{name}", hint)
        elif still_open:
            text = f"no pose within the limits closes this loop, so it starts open at {name}"
            log.report(
                "W-HOME", text, still_open, "widen limits in `joints`, or save the document in another pose"
            )
