"""Limits and dynamics that the key `joints` gives to dofs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.section import JointSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, Dynamics, Joint, Limits, Loop, Robot
from linkwright.stages.robot.motion.loops import POINTWISE
from linkwright.stages.robot.quantity_keys import as_typed, misfit
from linkwright.stages.robot.text.globs import fits, there_are

BEYOND = 1e-6
"""How far [rad or m] a saved value may lie beyond its limits before it is reported."""


def with_each_dof(robot: Robot, change: Callable[[Dof], Dof]) -> Robot:
    """The robot with every dof of its joints and loops changed."""
    joints = tuple(replace(j, dofs=tuple(change(dof) for dof in j.dofs)) for j in robot.joints)
    loops = tuple(replace(one, dofs=tuple(change(dof) for dof in one.dofs)) for one in robot.loops)
    return replace(robot, joints=joints, loops=loops)


def with_properties(robot: Robot, wanted: Mapping[str, JointSection], log: Diagnostics) -> Robot:
    """The robot with its dofs as the key `joints` has them: later entries win, field by field.

    Globs match names of dofs, those of loops too. E-GLOB for one that matches none, E-JOINT for limits
    that do not suit the dof. A saved turn is then moved by whole turns into its limits, where one fits.
    """
    dofs = (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs))
    for glob, keys in wanted.items():
        matched = [dof for dof in dofs if fits(dof.name, glob)]
        _check_glob(glob, keys, matched, robot, log)
        _check_gear(glob, keys, matched, wanted, log)
        _report_idle(glob, keys, robot.loops, log)
    return with_each_dof(robot, lambda dof: unwrapped(_with(dof, wanted)))


def _check_glob(
    glob: str, keys: JointSection, matched: Sequence[Dof], robot: Robot, log: Diagnostics
) -> None:
    if not matched:
        every: list[Joint | Loop] = [*robot.joints, *robot.loops]
        names = ", ".join(dof.name for one in every if fits(one.name, glob) for dof in one.dofs)
        if names:
            text = f"{glob!r} names a joint of several dofs (or several such joints), not one dof"
            log.report("E-GLOB", text, "joints", f"name one of its dofs: {names}")
            return
        hint = there_are(glob, {"joints": [dof.name for one in every for dof in one.dofs]})
        log.unmatched("E-GLOB", f"no joint matches {glob!r}", "joints", hint, glob)
    _check_units(glob, keys, matched, log)
    if keys.limits in (None, (None, None)):  # no limits suit dofs of every kind
        return
    kinds = {dof.kind for dof in matched}
    if len(kinds) > 1:
        named = ", ".join(f"{dof.name} ({dof.kind})" for dof in matched)
        text = f"{glob!r} gives one range to dofs of several kinds: {named}"
        log.report("E-JOINT", text, "joints", "give limits to each kind under its own glob")
    elif "free" in kinds:
        log.report("E-JOINT", f"{glob!r}: free motion takes no limits", "joints", "leave limits out")
    elif "ball" in kinds and keys.limits[0] is not None:
        text = f"{glob!r}: a ball has no lower limit, only a cone [rad] that its z axis stays in"
        log.report("E-JOINT", text, "joints", "limits: [null, cone]")


def _check_units(glob: str, keys: JointSection, matched: Sequence[Dof], log: Diagnostics) -> None:
    """E-JOINT for a length given to a turn, or an angle to a slide."""
    for key, values in (("limits", keys.limits or ()), ("zero", (keys.zero,))):
        wrong = [(text, dof) for value in values for dof in matched if (text := misfit(value, dof.kind))]
        for text, dof in wrong[:1]:
            text = f"{key} of {glob!r}: {text}, and {dof.name} is a {dof.kind}"
            log.report("E-JOINT", text, "joints", as_typed(dof.kind))


def _check_gear(
    glob: str,
    keys: JointSection,
    matched: Sequence[Dof],
    wanted: Mapping[str, JointSection],
    log: Diagnostics,
) -> None:
    """E-JOINT for a gear without a rotor, and for a rotor of what is neither a turn nor a slide."""
    rotors = [other for other, one in wanted.items() if one.rotor_inertia is not None]
    if (
        keys.gear is not None
        and matched
        and not any(fits(d.name, other) for d in matched for other in rotors)
    ):
        text = f"{glob!r} gives a gear to joints that have no rotor_inertia"
        hint = "give rotor_inertia too [kg m²]; the gear of an actuator is actuators.<name>.gear"
        log.report("E-JOINT", text, "joints", hint)
    if keys.rotor_inertia is not None and matched and not any(d.kind in ("turn", "slide") for d in matched):
        text = f"{glob!r} gives a rotor_inertia to {matched[0].name}, which is neither a turn nor a slide"
        log.report("E-JOINT", text, "joints", "give armature")


def _report_idle(glob: str, keys: JointSection, loops: Sequence[Loop], log: Diagnostics) -> None:
    """W-LOOP-DYNAMICS for dynamics of a dof that no simulation has; "*" means only those that it has."""
    given = [key for key in (*Dynamics.__slots__, "rotor_inertia") if getattr(keys, key) is not None]
    idle = [dof.name for one in loops if one.type in POINTWISE for dof in one.dofs]
    idle = [name for name in idle if fits(name, glob)]
    if glob != "*" and given and idle:
        text = f"the mate closes a loop by its points, where {', '.join(given)} of {glob!r} have no effect"
        hint = "let another mate close the loop (loops.cut), or remove these keys"
        log.report("W-LOOP-DYNAMICS", text, ", ".join(idle), hint)


def _with(dof: Dof, wanted: Mapping[str, JointSection]) -> Dof:
    """`by_name`: quantity that the key gives → whether an entry with the dof's own name does."""
    limits, dynamics = dof.limits, dof.dynamics
    by_name = dict.fromkeys(dof.given, False)
    rotor, gear, by_rotor = None, 1.0, False
    for glob, keys in wanted.items():
        if not fits(dof.name, glob):
            continue
        if keys.limits is not None:
            limits = Limits(*(None if end is None else float(end) for end in keys.limits))
            by_name["limits"] = glob == dof.name
        every = {key: getattr(keys, key) for key in Dynamics.__slots__}
        given = {key: value for key, value in every.items() if value is not None}
        dynamics = replace(dynamics, **given)
        by_name |= dict.fromkeys(given, glob == dof.name)
        gear = keys.gear or gear
        if keys.rotor_inertia is not None or keys.gear is not None:
            by_rotor = glob == dof.name
        # An armature and a rotor's inertia are two ways to give one value: the later one counts.
        rotor = (
            keys.rotor_inertia if keys.rotor_inertia is not None else None if "armature" in given else rotor
        )
    if rotor is not None and dof.kind in ("turn", "slide"):
        dynamics = replace(dynamics, armature=rotor * gear**2)
        by_name["armature"] = by_rotor
    named = tuple(sorted(name for name, own in by_name.items() if own))
    return replace(dof, limits=limits, dynamics=dynamics, given=tuple(sorted(by_name)), named=named)


def unwrapped(dof: Dof) -> Dof:
    """The dof with the saved value of a turn moved into its limits by whole turns, where one fits."""
    if dof.kind != "turn" or not isinstance(dof.saved, float):
        return dof
    return replace(dof, saved=dof.limits.unwrap(dof.saved, BEYOND))
