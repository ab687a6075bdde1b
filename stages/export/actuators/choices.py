"""What the key `actuators` says of each dof: types and parameters by glob, later entries first."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.configuration.actuator_section import fields_of
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.motion.couplings import nearest_first
from linkwright.stages.robot.quantity_keys import TypedNumber, as_typed, misfit
from linkwright.stages.robot.text.globs import as_key, did_you_mean, fits, listed, there_are

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.actuator_section import ActuatorSection
    from linkwright.stages.export.configuration.motor_section import MotorSection

WHERE = "actuators"

OF_ONE_KIND = ("kp", "kv", "ki", "imax", "slewmax", "ctrlrange", "forcerange")
"""Parameters whose unit depends on the kind of dof: one number cannot be right for a turn and a slide."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What the key says of a dof. `named`: by a name without wildcards, so that it is driven even where it
    follows others. `motor`: of the library, "" for none; `motor_named`: whether its entry has the dof's own
    name. `origin`: the entry that gives each parameter."""

    type: str
    parameters: Mapping[str, Any]
    named: bool
    motor: str = ""
    motor_named: bool = False
    origin: Mapping[str, str] = field(default_factory=dict)


def wanted_of(
    robot: Robot, entries: Mapping[str, ActuatorSection], motors: Mapping[str, MotorSection], log: Diagnostics
) -> dict[str, Wanted]:
    """By dof of the tree that an entry matches, in tree order; later entries win, property by property, and
    an entry with another type starts from that type's defaults, and keeps the motor. A motor that is named
    for the dof stays, whatever globs come later.

    E-GLOB for an entry but "*" that matches no dof; E-ACTUATOR for one that names a dof that cannot be
    driven, for parameters that are not of the type, and for a number for turns and slides at once; E-MOTOR
    for a motor that cannot drive the dof.
    """
    for glob, keys in entries.items():
        _check(glob, keys, robot, log)
    found: dict[str, Wanted] = {}
    for dof in robot.dofs:
        if dof.kind not in ("turn", "slide"):
            continue
        wanted = _merged(dof, entries, motors, log)
        if wanted is not None:
            found[dof.name] = wanted
    for glob in entries:
        _check_kinds(glob, found, robot, log)
    return found


def _merged(
    dof: Dof, entries: Mapping[str, ActuatorSection], motors: Mapping[str, MotorSection], log: Diagnostics
) -> Wanted | None:
    kind: str | None = None
    motor, motor_named = "", False
    parameters: dict[str, Any] = {}
    origin: dict[str, str] = {}
    named, matched = False, ""
    for glob, keys in entries.items():
        if not fits(dof.name, glob) or keys.only_measures:
            continue
        matched = glob
        if keys.type is not None and keys.type != kind:
            kind, parameters = keys.type, {}
        given = keys.given()
        if "kv" in given or "dampratio" in given:
            parameters = {name: one for name, one in parameters.items() if name not in ("kv", "dampratio")}
        parameters |= given
        # What is more specific wins: a motor that is named for the dof stays, whatever globs come later.
        if keys.motor and (glob == dof.name or not motor_named):
            motor, motor_named = keys.motor, glob == dof.name
        origin |= dict.fromkeys(given, glob)
        named = named or (glob == dof.name and kind != "none")
    if not matched:
        return None
    if kind == "none":
        motor = ""
    if motor and not _drives(motor, motors, dof, parameters, log):
        return None
    if kind is None and motor:
        kind = motors[motor].type
    if kind is None:
        text = f"{matched!r} has no type of actuator for {dof.name}"
        log.report("E-ACTUATOR", text, WHERE, "type: motor, position, velocity, ..., or a motor")
        return None
    wanted = Wanted(kind, parameters, named, motor, motor_named, origin)
    _judge(wanted, dof, matched, motors, log)
    if (control := parameters.get("ctrlrange")) is not None:
        _judge_control(wanted, dof, control, log)
        parameters["ctrlrange"] = tuple(float(end) for end in control)
    return wanted


def _judge_control(wanted: Wanted, dof: Dof, control: Sequence[float], log: Diagnostics) -> None:
    """E-ACTUATOR for an angle or a length that is not what the actuator's control is."""
    typed = [end for end in control if isinstance(end, TypedNumber)]
    if not typed:
        return
    kind, why = dof.kind, f"{dof.name} is a {dof.kind}"
    if wanted.motor:
        kind, why = "turn", f"the motor {wanted.motor} turns"
    text = misfit(typed[0], kind)
    hint = as_typed(kind)
    if wanted.type not in ("position", "pid"):
        text = f"{typed[0].typed!r} is an angle or a length"
        why = f"the control of type {wanted.type} is neither"
        hint = "give numbers in the unit of the control"
    if text:
        log.report("E-ACTUATOR", f"ctrlrange of {dof.name}: {text}, and {why}", WHERE, hint)


def _judge(
    wanted: Wanted, dof: Dof, matched: str, motors: Mapping[str, MotorSection], log: Diagnostics
) -> None:
    """E-ACTUATOR for parameters that the type does not have, and for those that need others."""
    allowed = fields_of(wanted.type)
    for name in wanted.parameters:
        if name not in allowed:
            entry = wanted.origin[name]
            text = f"{entry!r} gives {name}, which type {wanted.type} of {dof.name} does not have"
            hint = f"type {wanted.type} takes {', '.join(allowed) or 'nothing else'}"
            log.report("E-ACTUATOR", text, WHERE, hint)
    given = set(wanted.parameters)
    if wanted.motor and "nominal" not in given:
        known = motors[wanted.motor].values
        given |= {"motorconst"} if "torque_constant" in known else set()
        given |= {"resistance"} if "resistance" in known else set()
    for text, hint in _incomplete(wanted.type, given):
        log.report("E-ACTUATOR", f"{matched!r}: {text}, for {dof.name}", WHERE, hint)


def _drives(
    motor: str, motors: Mapping[str, MotorSection], dof: Dof, parameters: Mapping[str, Any], log: Diagnostics
) -> bool:
    """Whether the motor is known and can drive the dof."""
    if motor not in motors:
        hint = f"{did_you_mean(motor, motors)} motors: {', '.join(motors) or 'none'}"
        log.report("E-MOTOR", f"there is no motor {motor}", WHERE, hint.lstrip())
    elif dof.kind == "slide" and "gear" not in parameters:
        text = f"the motor {motor} turns, and {dof.name} slides"
        hint = f"give the turn of the motor per metre [rad/m]: actuators: {{{dof.name}: {{gear: ...}}}}"
        log.report("E-MOTOR", text, WHERE, hint)
    else:
        return True
    return False


def _incomplete(kind: str, parameters: Collection[str]) -> Iterator[tuple[str, str]]:
    """(problem, hint) of parameters that need others."""
    if "imax" in parameters and "ki" not in parameters:
        yield "imax limits the integral part, and there is none", "give ki"
    if "interp" in parameters and "delay" not in parameters:
        yield "interp is about a delayed control, and there is no delay", "give delay"
    constants = [name for name in ("motorconst", "resistance") if name in parameters]
    if kind == "dcmotor" and "nominal" in parameters and constants:
        text = f"nominal stands in place of {' and '.join(constants)}"
        yield text, "give nominal, or motorconst and resistance"
    elif kind == "dcmotor" and "nominal" not in parameters and len(constants) < 2:
        yield "type dcmotor lacks its motor", "give nominal, or motorconst and resistance"


def _check(glob: str, keys: ActuatorSection, robot: Robot, log: Diagnostics) -> None:
    every = [(dof, "") for dof in robot.dofs]
    every += [(dof, one.name) for one in robot.loops for dof in one.dofs]
    matched = [(dof, loop) for dof, loop in every if fits(dof.name, glob)]
    if not matched:
        _report_unmatched(glob, robot, log)
        return
    exact = next(((dof, loop) for dof, loop in matched if dof.name == glob), None)
    if exact is not None and keys.type != "none":
        dof, loop = exact
        if loop:
            text = f"{glob!r} closes a loop, and no joint of the tree, so nothing can drive it"
            log.report("E-ACTUATOR", text, WHERE, "let another mate close the loop (loops.cut)")
        elif dof.kind not in ("turn", "slide"):
            kind = "ball" if dof.kind == "ball" else "free joint"
            text = f"{glob!r} is a {kind}: an actuator drives one turn or slide"
            log.report("E-ACTUATOR", text, WHERE, f"name one of: {_names(robot)}")


def _check_kinds(glob: str, wanted: Mapping[str, Wanted], robot: Robot, log: Diagnostics) -> None:
    """E-ACTUATOR for parameters that turns and slides both have of this entry."""
    driven = [dof for dof in robot.dofs if dof.name in wanted]
    shared, example = [], {}
    for name in OF_ONE_KIND:
        kinds = {dof.kind: dof.name for dof in driven if _is_from(glob, name, wanted[dof.name])}
        if {"turn", "slide"} <= set(kinds):
            shared.append(name)
            example = kinds
    if shared:
        text = (
            f"{glob!r} gives one {' and one '.join(shared)} to turns ({example['turn']}, ...) and slides "
            f"({example['slide']}, ...), whose units differ"
        )
        numbers = ", ".join(f"{name}: ..." for name in shared)
        entry = f"actuators: {{{as_key(example['slide'])}: {{{numbers}}}}}"
        log.report("E-ACTUATOR", text, WHERE, f"give them to each kind under its own glob: {entry}")


def _is_from(glob: str, name: str, wanted: Wanted) -> bool:
    """Whether a parameter is what this entry gives."""
    return name in wanted.parameters and wanted.origin[name] == glob


def _report_unmatched(glob: str, robot: Robot, log: Diagnostics) -> None:
    of_joint = [dof.name for one in robot.joints if fits(one.name, glob) for dof in one.dofs]
    if of_joint:
        text = f"{glob!r} names a joint of several dofs (or several such joints), not one dof"
        log.report("E-GLOB", text, WHERE, f"name one of its dofs: {', '.join(of_joint)}")
        return
    hint = there_are(glob, {"joints": [dof.name for dof in robot.dofs]})
    log.unmatched("E-GLOB", f"no joint matches {glob!r}", WHERE, hint, glob)


def _names(robot: Robot) -> str:
    return listed(dof.name for dof in robot.dofs if dof.kind in ("turn", "slide"))


def driven_order(robot: Robot, wanted: Mapping[str, Wanted], own: Sequence[str]) -> list[str]:
    """The dofs that may be driven, the first ones first: those that the source drives and nobody changes,
    those that are named, drivers of relations, and then those nearest to the root; of several, that which
    moves the most mass.

    `own`: the dofs that keep the actuators of the source. Followers, and the passive joints of the source's
    SRDF, are left out unless they are named.
    """
    followers = {one.follower for one in robot.relations} | {*robot.semantics.passive}
    drivers = {one.driver for one in robot.relations}
    nearest = nearest_first(robot)
    asked = [name for name in nearest if name in wanted and wanted[name].type != "none"]
    named = [name for name in asked if wanted[name].named]
    free = [name for name in asked if name not in followers]
    masters = [name for name in free if name in drivers]
    return list(dict.fromkeys([*own, *named, *masters, *free]))
