"""Properties of dofs: what the user's YAML says of them, and whether their limits make sense."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from stages.graph.added_keys import AddedLinkKeys
from stages.graph.globs import as_key, fits, listed
from stages.graph.keys import JointKeys
from stages.robot.diagnostics import Diagnostics
from stages.robot.model import Dof, DofKind, Dynamics, Joint, Limits, Loop, Robot, Value

LOCKED_PLAY = 1e-6
"""Half the range [rad or m] of a dof whose limits are equal: MuJoCo takes none for unlimited."""

BEYOND = 1e-6
"""How far [rad or m] a saved value may lie beyond its limits before we say so."""

POINTWISE = frozenset({"fixed", "revolute", "ball"})
"""Types of loops that close by holding points together: no dof of theirs is in the simulation."""

UNITS: Mapping[DofKind, str] = {"turn": "rad", "slide": "m", "ball": "rad", "free": ""}


def with_each_dof(robot: Robot, change: Callable[[Dof], Dof]) -> Robot:
    """The robot with every dof of its joints and loops changed."""
    joints = tuple(replace(j, dofs=tuple(change(dof) for dof in j.dofs)) for j in robot.joints)
    loops = tuple(replace(one, dofs=tuple(change(dof) for dof in one.dofs)) for one in robot.loops)
    return replace(robot, joints=joints, loops=loops)


def with_properties(robot: Robot, wanted: Mapping[str, JointKeys], log: Diagnostics) -> Robot:
    """The robot with what `joints:` says about its dofs: later entries win, field by field.

    Globs match names of dofs, those of loops too. One that matches none is told (E-GLOB), and limits
    that cannot be meant (E-JOINT). A saved turn is then taken by whole turns into its limits, where one fits.
    """
    dofs = (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs))
    for glob, keys in wanted.items():
        _check_glob(glob, keys, [dof for dof in dofs if fits(dof.name, glob)], robot, log)
        _tell_idle(glob, keys, robot.loops, log)
    return with_each_dof(robot, lambda dof: unwrapped(_with(dof, wanted)))


def _check_glob(glob: str, keys: JointKeys, matched: Sequence[Dof], robot: Robot, log: Diagnostics) -> None:
    if not matched and glob != "*":
        every: list[Joint | Loop] = [*robot.joints, *robot.loops]
        names = ", ".join(dof.name for one in every if fits(one.name, glob) for dof in one.dofs)
        if names:
            text = f"{glob!r} is no dof: it has several of them (or stands for joints that have)"
            log.report("E-GLOB", text, "joints", f"say which: {names}")
            return
        known = listed(dof.name for one in every for dof in one.dofs)
        log.report("E-GLOB", f"no joint matches {glob!r}", "joints", f"joints are: {known or 'none'}")
    if keys.limits is None:
        return
    kinds = {dof.kind for dof in matched}
    if len(kinds) > 1:
        named = ", ".join(f"{dof.name} ({dof.kind})" for dof in matched)
        text = f"{glob!r} would give one range to dofs of several kinds: {named}"
        log.report("E-JOINT", text, "joints", "give limits to each kind under its own glob")
    elif "free" in kinds:
        log.report("E-JOINT", f"{glob!r}: free motion takes no limits", "joints", "leave limits out")
    elif "ball" in kinds and keys.limits[0] is not None:
        text = f"{glob!r}: a ball has no lower limit, only a cone [rad] that its z axis stays in"
        log.report("E-JOINT", text, "joints", "limits: [null, cone]")


def _tell_idle(glob: str, keys: JointKeys, loops: Sequence[Loop], log: Diagnostics) -> None:
    """What is said of a dof that no simulation has; "*" means those that it has."""
    given = [key for key in Dynamics.__slots__ if getattr(keys, key) is not None]
    idle = [dof.name for one in loops if one.type in POINTWISE for dof in one.dofs]
    idle = [name for name in idle if fits(name, glob)]
    if glob != "*" and given and idle:
        text = f"the mate closes a loop by its point, where {', '.join(given)} of {glob!r} act on nothing"
        hint = "let another mate close the loop (loops.cut), or leave it out"
        log.report("W-LOOP-DYNAMICS", text, ", ".join(idle), hint)


def _with(dof: Dof, wanted: Mapping[str, JointKeys]) -> Dof:
    limits, dynamics = dof.limits, dof.dynamics
    for glob, keys in wanted.items():
        if not fits(dof.name, glob):
            continue
        if keys.limits is not None:
            limits = Limits(*keys.limits)
        given = {key: getattr(keys, key) for key in Dynamics.__slots__}
        dynamics = replace(dynamics, **{key: value for key, value in given.items() if value is not None})
    return replace(dof, limits=limits, dynamics=dynamics)


def unwrapped(dof: Dof) -> Dof:
    """The dof with the saved value of a turn taken by whole turns into its limits, where one fits."""
    if dof.kind != "turn" or not isinstance(dof.saved, float):
        return dof
    low, high = ends(dof.limits)
    turns = 0
    if dof.saved < low - BEYOND:
        turns = math.ceil((low - BEYOND - dof.saved) / math.tau)
    elif dof.saved > high + BEYOND:
        turns = -math.ceil((dof.saved - high - BEYOND) / math.tau)
    saved = dof.saved + turns * math.tau
    return replace(dof, saved=saved) if low - BEYOND <= saved <= high + BEYOND else dof


def ends(limits: Limits) -> tuple[float, float]:
    """Both limits; an open one is infinite."""
    low = -math.inf if limits.lower is None else limits.lower
    return low, math.inf if limits.upper is None else limits.upper


def check_limits(
    robot: Robot,
    unknown: Mapping[str, str],
    log: Diagnostics,
    wanted: Mapping[str, JointKeys] | None = None,
    added: Mapping[str, AddedLinkKeys] | None = None,
    posed: bool = True,
) -> Robot:
    """Tells what limits lack or contradict; gives locked dofs the little play that engines need.

    `unknown`: why limits that CAD has are not known, by dof. `wanted` and `added`: what `joints:` and
    `links:` say; limits that they leave open are open on purpose. `posed`: whether someone drew the
    robot and left it in its saved pose.
    """
    settled = [glob for glob, keys in (wanted or {}).items() if keys.limits is not None]
    settled += [joint.name for joint in robot.joints if joint.mate is None and _settles(joint, added or {})]
    _tell_missing(robot, unknown, settled, log, posed)
    idle = {dof.name for loop in robot.loops if loop.type in POINTWISE for dof in loop.dofs}
    return with_each_dof(robot, lambda dof: dof if dof.name in idle else _checked(dof, log, posed))


def _settles(joint: Joint, added: Mapping[str, AddedLinkKeys]) -> bool:
    """Whether an added link's own keys say what its joint's limits are."""
    keys = added.get(joint.child)
    return keys is not None and (keys.joint.type == "continuous" or keys.joint.limits is not None)


def tell_loops(robot: Robot, unknown: Mapping[str, str], log: Diagnostics) -> None:
    """Tells what becomes of the limits of mates that close loops; that one has none is as it should be."""
    for loop in robot.loops:
        for dof in loop.dofs:
            if dof.name in unknown:
                text = f"its limits in CAD are not known: {unknown[dof.name]}"
                log.report("W-LIMIT", text, dof.name, "leave the mate that closes a loop without limits")
            if loop.type in POINTWISE and dof.limits != Limits():
                text = "this mate closes a loop, where its limits are not enforced"
                hint = "leave one mate of the loop without limits: it will be the one that closes it"
                log.report("W-LOOP-LIMIT", text, dof.name, hint)


def _tell_missing(
    robot: Robot, unknown: Mapping[str, str], settled: Sequence[str], log: Diagnostics, posed: bool
) -> None:
    """Every dof of the tree whose limits are not known or not there; one block of YAML for them all.

    What follows another is bounded by what drives it.
    """
    followers = {relation.follower for relation in robot.relations}
    lacking: list[tuple[Joint, Dof, str]] = []
    for joint in robot.joints:
        for dof in joint.dofs:
            if dof.kind == "free" or _endless(joint) or any(fits(dof.name, glob) for glob in settled):
                continue
            if dof.name in unknown:
                lacking.append((joint, dof, f"its limits in CAD are not known: {unknown[dof.name]}"))
            elif dof.kind != "ball" and dof.limits == Limits() and dof.name not in followers:
                freely = ": it turns freely" if dof.kind == "turn" else ""
                lacking.append((joint, dof, f"the joint has no limits{freely}"))
    for joint, dof, text in lacking:
        hint = f"set them {'on the mate' if posed else 'in the file'}, or " if joint.mate else ""
        hint += f"joints: {{{as_key(dof.name)}: {{limits: [low, high]}}}}  # {UNITS[dof.kind]}"
        if len(lacking) > 1 and dof is lacking[-1][1]:
            hint += f"\nall at once, null being open:\n{_block([dof for _, dof, _ in lacking])}"
        log.report("W-LIMIT", text, dof.name, hint)


def _endless(joint: Joint) -> bool:
    """Whether its source says outright that it has no limits, as a URDF's continuous joint does."""
    return joint.mate is not None and joint.mate.type in ("continuous", "planar")


def _block(dofs: Sequence[Dof]) -> str:
    """YAML that settles the limits of these dofs as they are."""

    def text(end: float | None) -> str:
        return "null" if end is None else f"{end:.9g}"

    lines = [
        f"  {as_key(dof.name)}: {{limits: [{text(dof.limits.lower)}, {text(dof.limits.upper)}]}}"
        f"  # {UNITS[dof.kind]}"
        for dof in dofs
    ]
    return "\n".join(["joints:", *lines])


def _checked(dof: Dof, log: Diagnostics, posed: bool) -> Dof:
    low, high = ends(dof.limits)
    settle = f"joints: {{{as_key(dof.name)}: {{limits: [low, high]}}}}  # {UNITS[dof.kind]}"
    if dof.kind == "ball" and dof.limits.upper is not None and not 0 < high <= math.pi:
        text = f"its cone of {high:.6g} rad is none: it must lie above 0 and not beyond π"
        log.report("E-LIMIT", text, dof.name, settle.replace("low, high", "null, cone"))
        return dof
    if low > high:
        text = f"the lower limit {low:.6g} is above the upper {high:.6g}"
        log.report("E-LIMIT", text, dof.name, f"mend the {'mate' if posed else 'file'}, or {settle}")
        return dof
    value = measured(dof.saved)
    if posed and value is not None and not low - BEYOND <= value <= high + BEYOND:
        text = f"the saved pose has it at {value:.6g}, outside its limits [{low:.6g}, {high:.6g}]"
        log.report("W-SAVED-POSE", text, dof.name, "move it back in Onshape, or mend the limits")
    if low == high:
        text = f"the joint is locked at {low:.6g}: it keeps a play of {LOCKED_PLAY:g} {UNITS[dof.kind]}"
        hint = "FASTEN the mate to make one link of it" if posed else "make it a fixed joint"
        log.report("W-LIMIT-LOCKED", f"{text} either way", dof.name, hint)
        return replace(dof, limits=Limits(low - LOCKED_PLAY, high + LOCKED_PLAY))
    return dof


def measured(value: Value) -> float | None:
    """What limits bound of a value: the number itself; of a ball the angle [rad] between the z axes
    before and after, 2 asin √(x² + y²); None of free motion."""
    if isinstance(value, float):
        return value
    if len(value) != 4:
        return None
    w, x, y, z = value
    return 2.0 * math.atan2(math.hypot(x, y), math.hypot(w, z))
