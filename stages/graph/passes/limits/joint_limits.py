"""Gives dofs the limits and dynamics of the key `joints`."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.section import JointSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, DofKind, Dynamics, Joint, Limits, Loop, Robot
from linkwright.stages.robot.motion.loops import POINTWISE
from linkwright.stages.robot.quantity_keys import TypedNumber, as_typed, misfit
from linkwright.stages.robot.text.globs import matches_glob, no_match_hint

LIMIT_TOLERANCE = 1e-6
"""Largest excess [rad or m] of a saved value over its limits that is not reported."""

LARGEST: Mapping[DofKind, tuple[float, str, str, str]] = {
    "turn": (4 * math.pi, "rad", "degrees", "deg"),
    "slide": (10.0, "m", "millimetres", "mm"),
}
"""Kind of a dof → the largest value that is plausible without a unit, its unit, the unit that a larger value
suggests, and that unit's abbreviation."""


def with_each_dof(robot: Robot, change: Callable[[Dof], Dof]) -> Robot:
    """Returns the robot with every dof of its joints and loops changed."""
    joints = tuple(replace(j, dofs=tuple(change(dof) for dof in j.dofs)) for j in robot.joints)
    loops = tuple(replace(loop, dofs=tuple(change(dof) for dof in loop.dofs)) for loop in robot.loops)
    return replace(robot, joints=joints, loops=loops)


def with_properties(robot: Robot, sections: Mapping[str, JointSection], log: Diagnostics) -> Robot:
    """Returns the robot with the limits and dynamics that the key `joints` gives to its dofs. Later entries
    win, field by field.

    Globs match names of dofs, those of loops too. Reports E-GLOB for a glob that matches no dof, E-JOINT for
    limits that do not suit the dof. Saved values of turns are then moved into the limits by whole turns, if
    possible.
    """
    dofs = (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs))
    for glob, keys in sections.items():
        matching_dofs = [dof for dof in dofs if matches_glob(dof.name, glob)]
        _check_glob(glob, keys, matching_dofs, robot, log)
        _check_gear(glob, keys, matching_dofs, sections, log)
        _report_idle(glob, keys, robot.loops, log)
    return with_each_dof(robot, lambda dof: unwrapped(_with_sections(dof, sections)))


def _check_glob(glob: str, keys: JointSection, dofs: Sequence[Dof], robot: Robot, log: Diagnostics) -> None:
    """Reports E-GLOB for a glob that matches no dof, and E-JOINT for limits that do not suit the dofs."""
    if not dofs:
        joints: list[Joint | Loop] = [*robot.joints, *robot.loops]
        names = ", ".join(
            dof.name for joint in joints if matches_glob(joint.name, glob) for dof in joint.dofs
        )
        if names:
            text = f"{glob!r} names a joint of several dofs (or several such joints), not one dof"
            log.report("E-GLOB", text, "joints", f"name one of its dofs: {names}")
            return
        hint = no_match_hint(glob, {"joints": [dof.name for joint in joints for dof in joint.dofs]})
        log.unmatched("E-GLOB", f"no joint matches {glob!r}", "joints", hint, glob)
    _check_units(glob, keys, dofs, log)
    if keys.limits in (None, (None, None)):  # no limits suit dofs of every kind
        return
    kinds = {dof.kind for dof in dofs}
    if len(kinds) > 1:
        description = ", ".join(f"{dof.name} ({dof.kind})" for dof in dofs)
        text = f"{glob!r} gives one range to dofs of several kinds: {description}"
        log.report("E-JOINT", text, "joints", "give limits to each kind under its own glob")
    elif "free" in kinds:
        log.report("E-JOINT", f"{glob!r}: free motion takes no limits", "joints", "leave limits out")
    elif "ball" in kinds and keys.limits[0] is not None:
        text = f"{glob!r}: a ball has no lower limit, only a cone [rad] that its z axis stays in"
        log.report("E-JOINT", text, "joints", "limits: [null, cone]")


def _check_units(glob: str, keys: JointSection, dofs: Sequence[Dof], log: Diagnostics) -> None:
    """Reports E-JOINT for a length given to a turn, or an angle to a slide."""
    for key, values in (("limits", keys.limits or ()), ("zero", (keys.zero,))):
        wrong = [(text, dof) for value in values for dof in dofs if (text := misfit(value, dof.kind))]
        for text, dof in wrong[:1]:
            text = f"{key} of {glob!r}: {text}, and {dof.name} is a {dof.kind}"
            log.report("E-JOINT", text, "joints", as_typed(dof.kind))
        _report_large(key, glob, [value for value in values if value is not None], dofs, log)


def _report_large(
    key: str, glob: str, values: Sequence[float], dofs: Sequence[Dof], log: Diagnostics
) -> None:
    """Reports W-UNIT for numbers without a unit that are implausibly large in SI."""
    for dof in dofs:
        if dof.kind not in LARGEST:
            continue
        largest, unit, looks_like, short = LARGEST[dof.kind]
        large = [value for value in values if not isinstance(value, TypedNumber) and abs(value) > largest]
        if large:
            text = f"{key} of {glob!r}: {large[0]:g} is taken as {unit}; it looks like {looks_like}"
            hint = f"write the unit: '{large[0]:g} {short}', or '{large[0]:g} {unit}' if {unit} is meant"
            log.report("W-UNIT", text, "joints", hint)
            return


def _check_gear(
    glob: str,
    keys: JointSection,
    dofs: Sequence[Dof],
    sections: Mapping[str, JointSection],
    log: Diagnostics,
) -> None:
    """Reports E-JOINT for a gear without a rotor, and for a rotor on a dof that is neither a turn nor a
    slide."""
    rotors = [other for other, section in sections.items() if section.rotor_inertia is not None]
    if (
        keys.gear is not None
        and dofs
        and not any(matches_glob(d.name, other) for d in dofs for other in rotors)
    ):
        text = f"{glob!r} gives a gear to joints that have no rotor_inertia"
        hint = "give rotor_inertia too [kg m²]; the gear of an actuator is actuators.<name>.gear"
        log.report("E-JOINT", text, "joints", hint)
    if keys.rotor_inertia is not None and dofs and not any(d.kind in ("turn", "slide") for d in dofs):
        text = f"{glob!r} gives a rotor_inertia to {dofs[0].name}, which is neither a turn nor a slide"
        log.report("E-JOINT", text, "joints", "give armature")


def _report_idle(glob: str, keys: JointSection, loops: Sequence[Loop], log: Diagnostics) -> None:
    """Reports W-LOOP-DYNAMICS for dynamics of dofs that are not simulated. The glob "*" means only the
    simulated dofs, so it is not reported."""
    quantities = [key for key in (*Dynamics.__slots__, "rotor_inertia") if getattr(keys, key) is not None]
    idle = [dof.name for loop in loops if loop.type in POINTWISE for dof in loop.dofs]
    idle = [name for name in idle if matches_glob(name, glob)]
    if glob != "*" and quantities and idle:
        text = (
            f"the mate closes a loop by its points, where {', '.join(quantities)} of {glob!r} have no effect"
        )
        hint = "let another mate close the loop (loops.cut), or remove these keys"
        log.report("W-LOOP-DYNAMICS", text, ", ".join(idle), hint)


def _with_sections(dof: Dof, sections: Mapping[str, JointSection]) -> Dof:
    """Returns the dof with the properties of the sections that match it."""
    limits, dynamics = dof.limits, dof.dynamics
    by_name = dict.fromkeys(dof.given, False)
    rotor, gear, by_rotor = None, 1.0, False
    for glob, keys in sections.items():
        if not matches_glob(dof.name, glob):
            continue
        if keys.limits is not None:
            limits = Limits(*(None if end is None else float(end) for end in keys.limits))
            by_name["limits"] = glob == dof.name
        properties = {key: getattr(keys, key) for key in Dynamics.__slots__}
        values = {key: value for key, value in properties.items() if value is not None}
        dynamics = replace(dynamics, **values)
        by_name |= dict.fromkeys(values, glob == dof.name)
        gear = keys.gear or gear
        if keys.rotor_inertia is not None or keys.gear is not None:
            by_rotor = glob == dof.name
        # An armature and a rotor's inertia are two ways to give one value: the later one counts.
        rotor = (
            keys.rotor_inertia if keys.rotor_inertia is not None else None if "armature" in values else rotor
        )
    if rotor is not None and dof.kind in ("turn", "slide"):
        # An inertia at the rotor acts on the joint with the square of the gear.
        dynamics = replace(dynamics, armature=rotor * gear**2)
        by_name["armature"] = by_rotor
    named_entries = tuple(sorted(name for name, by_own_name in by_name.items() if by_own_name))
    return replace(dof, limits=limits, dynamics=dynamics, given=tuple(sorted(by_name)), named=named_entries)


def unwrapped(dof: Dof) -> Dof:
    """Returns the dof with the saved value of a turn moved into its limits by whole turns, where that is
    possible."""
    if dof.kind != "turn" or not isinstance(dof.saved, float):
        return dof
    return replace(dof, saved=dof.limits.unwrap(dof.saved, LIMIT_TOLERANCE))
