"""Gives dofs the limits and dynamics of the key `joints`."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from linkwright.stages.graph.section import JointSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, DofKind, Dynamics, Joint, Limits, Loop, Robot
from linkwright.stages.robot.motion.loops import POINTWISE_TYPES
from linkwright.stages.robot.quantity_keys import TypedNumber, misfit, unit_hint
from linkwright.stages.robot.text.globs import matches_glob, no_match_hint

LIMIT_TOLERANCE = 1e-6
"""Largest excess [rad or m] of a saved value over its limits that is not reported."""


class PlausibleValues(NamedTuple):
    """The values of a dof that are plausible without a unit: `largest`, in `unit`. A larger value suggests
    another unit, `confused_unit`, whose `abbreviation` users write."""

    largest: float
    unit: str
    confused_unit: str
    abbreviation: str


PLAUSIBLE_VALUES: Mapping[DofKind, PlausibleValues] = {
    "turn": PlausibleValues(4 * math.pi, "rad", "degrees", "deg"),
    "slide": PlausibleValues(10.0, "m", "millimetres", "mm"),
}


def with_each_dof(robot: Robot, change: Callable[[Dof], Dof]) -> Robot:
    """Returns the robot with every dof of its joints and loops changed."""
    joints = tuple(replace(joint, dofs=tuple(change(dof) for dof in joint.dofs)) for joint in robot.joints)
    loops = tuple(replace(loop, dofs=tuple(change(dof) for dof in loop.dofs)) for loop in robot.loops)
    return replace(robot, joints=joints, loops=loops)


def with_limits_and_dynamics(robot: Robot, sections: Mapping[str, JointSection], log: Diagnostics) -> Robot:
    """Returns the robot with the limits and dynamics that the key `joints` gives to its dofs. Later entries
    win, field by field.

    Globs match names of dofs, those of loops too. Reports E-GLOB for a glob that matches no dof, E-JOINT for
    limits that do not suit the dof. Saved values of turns are then moved into the limits by whole turns, if
    possible.
    """
    dofs = (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs))
    for glob, section in sections.items():
        matching_dofs = [dof for dof in dofs if matches_glob(dof.name, glob)]
        _check_glob(glob, section, matching_dofs, robot, log)
        _check_gear(glob, section, matching_dofs, sections, log)
        _report_idle(glob, section, robot.loops, log)
    return with_each_dof(robot, lambda dof: unwrapped(_with_sections(dof, sections)))


def _check_glob(
    glob: str, section: JointSection, dofs: Sequence[Dof], robot: Robot, log: Diagnostics
) -> None:
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
        log.report_unmatched("E-GLOB", f"no joint matches {glob!r}", "joints", hint, glob)
    _check_units(glob, section, dofs, log)
    _check_limits(glob, section, dofs, log)


def _check_limits(glob: str, section: JointSection, dofs: Sequence[Dof], log: Diagnostics) -> None:
    """Reports E-JOINT for limits that do not suit the kinds of the dofs."""
    if section.limits in (None, (None, None)):
        return
    kinds = {dof.kind for dof in dofs}
    if len(kinds) > 1:
        description = ", ".join(f"{dof.name} ({dof.kind})" for dof in dofs)
        text = f"{glob!r} gives one range to dofs of several kinds: {description}"
        log.report("E-JOINT", text, "joints", "give limits to each kind under its own glob")
    elif "free" in kinds:
        log.report("E-JOINT", f"{glob!r}: free motion takes no limits", "joints", "leave limits out")
    elif "ball" in kinds and section.limits[0] is not None:
        text = f"{glob!r}: a ball has no lower limit, only a cone [rad] that its z axis stays in"
        log.report("E-JOINT", text, "joints", "limits: [null, cone]")


def _check_units(glob: str, section: JointSection, dofs: Sequence[Dof], log: Diagnostics) -> None:
    """Reports E-JOINT for a length given to a turn, or an angle to a slide."""
    for key, values in (("limits", section.limits or ()), ("zero", (section.zero,))):
        wrong = [(text, dof) for value in values for dof in dofs if (text := misfit(value, dof.kind))]
        for text, dof in wrong[:1]:
            text = f"{key} of {glob!r}: {text}, and {dof.name} is a {dof.kind}"
            log.report("E-JOINT", text, "joints", unit_hint(dof.kind))
        _report_large(key, glob, [value for value in values if value is not None], dofs, log)


def _report_large(
    key: str, glob: str, values: Sequence[float], dofs: Sequence[Dof], log: Diagnostics
) -> None:
    """Reports W-UNIT for numbers without a unit that are implausibly large in SI."""
    for dof in dofs:
        if dof.kind not in PLAUSIBLE_VALUES:
            continue
        largest, unit, confused_unit, abbreviation = PLAUSIBLE_VALUES[dof.kind]
        large = [value for value in values if not isinstance(value, TypedNumber) and abs(value) > largest]
        if large:
            text = f"{key} of {glob!r}: {large[0]:g} is taken as {unit}; it looks like {confused_unit}"
            hint = (
                f"write the unit: '{large[0]:g} {abbreviation}', or '{large[0]:g} {unit}' if {unit} is meant"
            )
            log.report("W-UNIT", text, "joints", hint)
            return


def _check_gear(
    glob: str,
    section: JointSection,
    dofs: Sequence[Dof],
    sections: Mapping[str, JointSection],
    log: Diagnostics,
) -> None:
    """Reports E-JOINT for a gear without a rotor, and for a rotor on a dof that is neither a turn nor a
    slide."""
    rotor_globs = [key for key, entry in sections.items() if entry.rotor_inertia is not None]
    has_rotor = any(matches_glob(dof.name, rotor_glob) for dof in dofs for rotor_glob in rotor_globs)
    if section.gear is not None and dofs and not has_rotor:
        text = f"{glob!r} gives a gear to joints that have no rotor_inertia"
        hint = "give rotor_inertia too [kg m²]; the gear of an actuator is actuators.<name>.gear"
        log.report("E-JOINT", text, "joints", hint)
    if section.rotor_inertia is not None and dofs and not any(dof.kind in ("turn", "slide") for dof in dofs):
        text = f"{glob!r} gives a rotor_inertia to {dofs[0].name}, which is neither a turn nor a slide"
        log.report("E-JOINT", text, "joints", "give armature")


def _report_idle(glob: str, section: JointSection, loops: Sequence[Loop], log: Diagnostics) -> None:
    """Reports W-LOOP-DYNAMICS for dynamics of dofs that are not simulated. The glob "*" means only the
    simulated dofs, so it is not reported."""
    quantities = [key for key in (*Dynamics.__slots__, "rotor_inertia") if getattr(section, key) is not None]
    idle = [dof.name for loop in loops if loop.type in POINTWISE_TYPES for dof in loop.dofs]
    idle = [name for name in idle if matches_glob(name, glob)]
    if glob != "*" and quantities and idle:
        verb = "has" if len(quantities) == 1 else "have"
        effect = f"{', '.join(quantities)} of {glob!r} {verb} no effect"
        text = f"the mate closes a loop by its points, where {effect}"
        hint = "let another mate close the loop (loops.cut), or remove these keys"
        log.report("W-LOOP-DYNAMICS", text, ", ".join(idle), hint)


def _with_sections(dof: Dof, sections: Mapping[str, JointSection]) -> Dof:
    """Returns the dof with the properties of the sections that match it."""
    limits, dynamics = dof.limits, dof.dynamics
    set_by_own_name = dict.fromkeys(dof.given, False)
    rotor, gear, rotor_by_own_name = None, 1.0, False
    for glob, section in sections.items():
        if not matches_glob(dof.name, glob):
            continue
        if section.limits is not None:
            limits = Limits(*(None if end is None else float(end) for end in section.limits))
            set_by_own_name["limits"] = glob == dof.name
        properties = {key: getattr(section, key) for key in Dynamics.__slots__}
        values = {key: value for key, value in properties.items() if value is not None}
        dynamics = replace(dynamics, **values)
        set_by_own_name |= dict.fromkeys(values, glob == dof.name)
        gear = section.gear or gear
        if section.rotor_inertia is not None or section.gear is not None:
            rotor_by_own_name = glob == dof.name
        # An armature and a rotor's inertia are two ways to give one value: the later one counts.
        if section.rotor_inertia is not None:
            rotor = section.rotor_inertia
        elif "armature" in values:
            rotor = None
    if rotor is not None and dof.kind in ("turn", "slide"):
        # An inertia at the rotor acts on the joint with the square of the gear.
        dynamics = replace(dynamics, armature=rotor * gear**2)
        set_by_own_name["armature"] = rotor_by_own_name
    named_entries = tuple(sorted(name for name, is_own in set_by_own_name.items() if is_own))
    return replace(
        dof, limits=limits, dynamics=dynamics, given=tuple(sorted(set_by_own_name)), named=named_entries
    )


def unwrapped(dof: Dof) -> Dof:
    """Returns the dof with the saved value of a turn moved into its limits by whole turns, where that is
    possible."""
    if dof.kind != "turn" or not isinstance(dof.saved, float):
        return dof
    return replace(dof, saved=dof.limits.unwrap(dof.saved, LIMIT_TOLERANCE))
