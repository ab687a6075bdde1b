"""Checks limits: missing, unknown, contradictory, or without effect."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.added_section import AddedLinkSection
from linkwright.stages.graph.mechanism import Mechanism
from linkwright.stages.graph.passes.limits.joint_limits import LIMIT_TOLERANCE, with_each_dof
from linkwright.stages.graph.section import GraphSections, JointSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.dofs import AS_TYPED
from linkwright.stages.robot.model.robot import Dof, DofKind, Joint, Limits, Loop, Robot, Value
from linkwright.stages.robot.motion.loops import POINTWISE_TYPES
from linkwright.stages.robot.text.globs import matches_glob, yaml_key

LOCKED_PLAY = 1e-6
"""Half the range [rad or m] of a dof whose limits are equal: to MuJoCo an empty range means no limit."""

UNITS: Mapping[DofKind, str] = {"turn": "rad", "slide": "m", "ball": "rad", "free": ""}


def with_checked_limits(robot: Robot, mechanism: Mechanism, keys: GraphSections, log: Diagnostics) -> Robot:
    """Returns the robot with every limit checked; wrong, missing and doubtful limits are reported."""
    _report_doubts(robot, log)
    robot = check_limits(robot, log, keys.joints, keys.links, mechanism.has_saved_pose)
    report_loop_limits(robot, log)
    return robot


def _report_doubts(robot: Robot, log: Diagnostics) -> None:
    """Reports limits in CAD that may be meant otherwise, for mates whose limits are not all in `joints:`."""
    joints: list[Joint | Loop] = [*robot.joints, *robot.loops]
    for joint in joints:
        dof = next((dof for dof in joint.dofs if dof.limits.origin != AS_TYPED), None)
        if dof is None:
            continue
        entry = f"joints: {{{yaml_key(dof.name)}: {{limits: [low, high]}}}}"
        for text in dof.limits.origin.doubts:
            log.report("W-LIMIT-DOUBT", text, joint.name, f"type it again on the mate, or {entry}")
        for text in dof.limits.origin.open:
            log.report("I-LIMIT-OPEN", text, joint.name, f"if 0 is meant, type it in Onshape, or {entry}")


def check_limits(
    robot: Robot,
    log: Diagnostics,
    sections: Mapping[str, JointSection] | None = None,
    added: Mapping[str, AddedLinkSection] | None = None,
    has_saved_pose: bool = True,
) -> Robot:
    """Reports missing and contradictory limits, and gives locked dofs the small range that engines need.

    `sections`, `added`: the keys `joints` and `links`; limits that they leave open are open on purpose.
    `has_saved_pose`: whether the source is an assembly with a saved pose.
    """
    decided_globs = [glob for glob, keys in (sections or {}).items() if keys.limits is not None]
    decided_globs += [
        joint.name for joint in robot.joints if joint.mate is None and _decides(joint, added or {})
    ]
    _report_missing(robot, decided_globs, log, has_saved_pose)
    unenforced_dofs = {dof.name for loop in robot.loops if loop.type in POINTWISE_TYPES for dof in loop.dofs}
    return with_each_dof(
        robot, lambda dof: dof if dof.name in unenforced_dofs else _check_dof(dof, log, has_saved_pose)
    )


def _decides(joint: Joint, added: Mapping[str, AddedLinkSection]) -> bool:
    """Tells whether the keys of an added link decide the limits of its joint."""
    keys = added.get(joint.child)
    return keys is not None and (keys.joint.type == "continuous" or keys.joint.limits is not None)


def report_loop_limits(robot: Robot, log: Diagnostics) -> None:
    """Reports limits of mates that close loops: unknown limits, and those that no engine enforces."""
    for loop in robot.loops:
        for dof in loop.dofs:
            if dof.limits.origin.unknown:
                text = f"its limits in CAD are unknown: {dof.limits.origin.unknown}"
                log.report("W-LIMIT", text, dof.name, "leave the mate that closes a loop without limits")
            if loop.type in POINTWISE_TYPES and dof.limits != Limits():
                text = "this mate closes a loop, where its limits are not enforced"
                hint = "leave one mate of the loop without limits: that mate will close it"
                log.report("W-LOOP-LIMIT", text, dof.name, hint)


def _report_missing(
    robot: Robot, decided_globs: Sequence[str], log: Diagnostics, has_saved_pose: bool
) -> None:
    """Reports W-LIMIT for every dof of the tree without limits; the last report has a block of YAML for all
    of them. Followers are not reported, since their drivers limit them.
    """
    followers = {relation.follower for relation in robot.relations}
    unlimited_dofs: list[tuple[Joint, Dof, str]] = []
    for joint in robot.joints:
        for dof in joint.dofs:
            if (
                dof.kind == "free"
                or _is_endless(joint)
                or any(matches_glob(dof.name, glob) for glob in decided_globs)
            ):
                continue
            if dof.limits.origin.unknown:
                unlimited_dofs.append(
                    (joint, dof, f"its limits in CAD are unknown: {dof.limits.origin.unknown}")
                )
            elif dof.kind != "ball" and dof.limits == Limits() and dof.name not in followers:
                freely = ": it turns freely" if dof.kind == "turn" else ""
                unlimited_dofs.append((joint, dof, f"the joint has no limits{freely}"))
    for joint, dof, text in unlimited_dofs:
        hint = f"set them {'on the mate' if has_saved_pose else 'in the file'}, or " if joint.mate else ""
        hint += _limits_entry(dof)
        if len(unlimited_dofs) > 1 and dof is unlimited_dofs[-1][1]:
            hint += f"\nall at once, null being open:\n{_block([dof for _, dof, _ in unlimited_dofs])}"
        log.report("W-LIMIT", text, dof.name, hint)


def _is_endless(joint: Joint) -> bool:
    """Tells whether the source declares that a joint has no limits, as a URDF does for a continuous joint."""
    return joint.mate is not None and joint.mate.type in ("continuous", "planar")


def _limits_entry(dof: Dof, values: str = "low, high") -> str:
    """Returns the line of YAML that gives a dof its limits."""
    return f"joints: {{{yaml_key(dof.name)}: {{limits: [{values}]}}}}  # {UNITS[dof.kind]}"


def _block(dofs: Sequence[Dof]) -> str:
    """Returns YAML that keeps the limits of these dofs as they are."""

    def end_text(end: float | None) -> str:
        return "null" if end is None else f"{end:.9g}"

    lines = [
        f"  {yaml_key(dof.name)}: {{limits: [{end_text(dof.limits.lower)}, {end_text(dof.limits.upper)}]}}"
        f"  # {UNITS[dof.kind]}"
        for dof in dofs
    ]
    return "\n".join(["joints:", *lines])


def _check_dof(dof: Dof, log: Diagnostics, has_saved_pose: bool) -> Dof:
    low, high = dof.limits.interval
    if dof.kind == "ball" and dof.limits.upper is not None and not 0 < high <= math.pi:
        text = f"invalid cone {high:.6g} rad: must be in (0, π]"
        log.report("E-LIMIT", text, dof.name, _limits_entry(dof, "null, cone"))
        return dof
    if low > high:
        text = f"the lower limit {low:.6g} is above the upper limit {high:.6g}"
        hint = f"correct the {'mate' if has_saved_pose else 'file'}, or {_limits_entry(dof)}"
        log.report("E-LIMIT", text, dof.name, hint)
        return dof
    value = limited_quantity(dof.saved)
    if has_saved_pose and value is not None and not dof.limits.contains(value, LIMIT_TOLERANCE):
        text = f"its value in the saved pose, {value:.6g}, is outside its limits [{low:.6g}, {high:.6g}]"
        log.report(
            "W-SAVED-POSE", text, dof.name, "move the joint into its limits in Onshape, or correct the limits"
        )
    if low == high:
        text = f"the joint is locked at {low:.6g}: it gets a range of {LOCKED_PLAY:g} {UNITS[dof.kind]}"
        hint = "FASTEN the mate to make one link of it" if has_saved_pose else "make it a fixed joint"
        log.report("W-LIMIT-LOCKED", f"{text} either way", dof.name, hint)
        return replace(dof, limits=replace(dof.limits, lower=low - LOCKED_PLAY, upper=high + LOCKED_PLAY))
    return dof


def limited_quantity(value: Value) -> float | None:
    """Returns the quantity to which limits apply: for a turn or slide the value itself; for a ball the angle
    [rad] between the z axes before and after, 2 asin √(x² + y²). Returns None for free motion."""
    if isinstance(value, float):
        return value
    if len(value) != 4:
        return None
    w, x, y, z = value
    return 2.0 * math.atan2(math.hypot(x, y), math.hypot(w, z))
