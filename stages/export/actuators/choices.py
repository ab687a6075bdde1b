"""Chooses the type and parameters of each dof's actuator from the key `actuators`; later entries win."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.configuration.actuator_section import fields_of
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.motion.couplings import nearest_first
from linkwright.stages.robot.quantity_keys import TypedNumber, misfit, unit_hint
from linkwright.stages.robot.text.globs import did_you_mean, matches_glob, name_list, no_match_hint, yaml_key

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.actuator_section import ActuatorSection
    from linkwright.stages.export.configuration.motor_section import MotorSection

WHERE = "actuators"

OF_ONE_KIND = ("kp", "kv", "ki", "imax", "slewmax", "ctrlrange", "forcerange")
"""Parameters whose unit depends on the kind of dof: one number cannot be right for a turn and a slide."""


@dataclass(frozen=True, slots=True)
class ChosenActuator:
    """The actuator that the key `actuators` chooses for a dof."""

    type: str
    parameters: Mapping[str, Any]

    named: bool
    """Whether an entry names the dof without wildcards: it is driven then even if it follows other dofs."""

    motor: str = ""
    """The name of its motor in the library; "" without a motor."""

    motor_named: bool = False
    """Whether the entry that assigns the motor has the dof's own name."""

    origin: Mapping[str, str] = field(default_factory=dict)
    """Parameter → the glob of the entry that sets it."""


def choose_actuators(
    robot: Robot, entries: Mapping[str, ActuatorSection], motors: Mapping[str, MotorSection], log: Diagnostics
) -> dict[str, ChosenActuator]:
    """Returns the choice for each dof of the tree that an entry matches, in tree order.

    Later entries win, property by property. An entry with another type than the earlier entries, or than
    their motor, starts from that type's defaults and keeps the motor. A motor that is assigned to the dof by
    name stays, whatever globs come later.

    Reports an entry other than "*" that matches no dof (E-GLOB); an entry that names a dof that cannot be
    driven, a dof without a type, a parameter or a motor that the type does not have, and a number that
    applies to both turns and slides (E-ACTUATOR); and a motor that cannot drive the dof (E-MOTOR).
    """
    for glob, section in entries.items():
        _check_dofs(glob, section, robot, log)
    choices: dict[str, ChosenActuator] = {}
    for dof in robot.dofs:
        if dof.kind not in ("turn", "slide"):
            continue
        choice = _choice_of(dof, entries, motors, log)
        if choice is not None:
            choices[dof.name] = choice
    for glob in entries:
        _check_kinds(glob, choices, robot, log)
    return choices


@dataclass(slots=True)
class _MergedEntries:
    """The entries that match a dof, merged in their order."""

    dof: str
    type: str | None = None
    parameters: dict[str, Any] = field(default_factory=dict)
    origin: dict[str, str] = field(default_factory=dict)

    named: bool = False
    """Whether an entry names the dof without wildcards, and drives it."""

    motor: str = ""
    motor_named: bool = False

    idle_motor_glob: str = ""
    """The glob of the last entry that gives a motor but no type, after an entry of the type none; else ""."""

    last_glob: str = ""
    """The glob of the last entry that matches; "" before the first."""

    def merge(self, glob: str, section: ActuatorSection, motors: Mapping[str, MotorSection]) -> None:
        """Lets an entry that matches the dof override the earlier ones."""
        is_exact = glob == self.dof
        self.last_glob = glob
        if section.type is not None:
            motor_type = motors[self.motor].type if self.motor in motors else None
            if (self.type or motor_type) not in (None, section.type):
                self.parameters = {}
            self.type = section.type
            self.idle_motor_glob = ""
        parameters = section.explicit()
        if "kv" in parameters or "dampratio" in parameters:
            # They exclude each other.
            self.parameters.pop("kv", None)
            self.parameters.pop("dampratio", None)
        self.parameters |= parameters
        self.origin |= dict.fromkeys(parameters, glob)
        # What is more specific wins: a motor that is named for the dof stays, whatever globs come later.
        if section.motor and (is_exact or not self.motor_named):
            self.motor, self.motor_named = section.motor, is_exact
            self.idle_motor_glob = glob if self.type == "none" else ""
        self.named = self.named or (is_exact and self.type != "none")


def _choice_of(
    dof: Dof, entries: Mapping[str, ActuatorSection], motors: Mapping[str, MotorSection], log: Diagnostics
) -> ChosenActuator | None:
    """Returns the choice for a turn or slide; None without an entry for it, or if its entries have a problem
    that leaves no choice."""
    merged = _MergedEntries(dof.name)
    for glob, section in entries.items():
        if matches_glob(dof.name, glob) and not section.only_measures:
            merged.merge(glob, section, motors)
    if not merged.last_glob:
        return None
    if merged.idle_motor_glob:
        text = (
            f"{merged.idle_motor_glob!r} gives a motor, but an earlier entry gives {dof.name} the type none"
        )
        log.report("E-ACTUATOR", text, WHERE, "give a type, too: position, motor, ...")
        return None
    motor = "" if merged.type == "none" else merged.motor
    if motor and not _can_drive(motor, motors, dof, merged.parameters, log):
        return None
    kind = merged.type
    if kind is None and motor:
        kind = motors[motor].type
    if kind is None:
        text = f"{merged.last_glob!r} gives no actuator type for {dof.name}"
        log.report("E-ACTUATOR", text, WHERE, "type: motor, position, velocity, ..., or a motor")
        return None
    parameters = merged.parameters
    choice = ChosenActuator(kind, parameters, merged.named, motor, merged.motor_named, merged.origin)
    _check_parameters(choice, dof, merged.last_glob, motors, log)
    if (control := parameters.get("ctrlrange")) is not None:
        _check_control(choice, dof, control, log)
        parameters["ctrlrange"] = tuple(float(end) for end in control)
    return choice


def _check_control(choice: ChosenActuator, dof: Dof, control: Sequence[float], log: Diagnostics) -> None:
    """Reports an angle or a length as the range of a control with another unit (E-ACTUATOR)."""
    dimensioned = [end for end in control if isinstance(end, TypedNumber)]
    if not dimensioned:
        return
    kind, why = dof.kind, f"{dof.name} is a {dof.kind}"
    if choice.motor:
        kind, why = "turn", f"the motor {choice.motor} turns"
    text = next((problem for end in dimensioned if (problem := misfit(end, kind))), "")
    hint = unit_hint(kind)
    if choice.type not in ("position", "pid"):
        text = f"{dimensioned[0].typed!r} is an angle or a length"
        why = f"the control of type {choice.type} is neither"
        hint = "give numbers in the unit of the control"
    if text:
        log.report("E-ACTUATOR", f"ctrlrange of {dof.name}: {text}, and {why}", WHERE, hint)


def _check_parameters(
    choice: ChosenActuator, dof: Dof, last_glob: str, motors: Mapping[str, MotorSection], log: Diagnostics
) -> None:
    """Reports parameters that the type does not have, and incomplete sets of parameters (E-ACTUATOR)."""
    allowed = fields_of(choice.type)
    for name in choice.parameters:
        if name not in allowed:
            entry = choice.origin[name]
            text = f"{entry!r} gives {name}, which type {choice.type} of {dof.name} does not have"
            hint = f"type {choice.type} takes {', '.join(allowed) or 'nothing else'}"
            log.report("E-ACTUATOR", text, WHERE, hint)
    names = set(choice.parameters)
    if choice.motor and "nominal" not in names:
        values = motors[choice.motor].values
        names |= {"motorconst"} if "torque_constant" in values else set()
        names |= {"resistance"} if "resistance" in values else set()
    for text, hint in _incomplete(choice.type, names):
        log.report("E-ACTUATOR", f"{last_glob!r}: {text}, for {dof.name}", WHERE, hint)


def _can_drive(
    motor: str, motors: Mapping[str, MotorSection], dof: Dof, parameters: Mapping[str, Any], log: Diagnostics
) -> bool:
    """Reports a motor that does not exist or cannot drive the dof (E-MOTOR); returns whether it can."""
    if motor not in motors:
        hint = f"{did_you_mean(motor, motors)} motors: {', '.join(motors) or 'none'}"
        log.report("E-MOTOR", f"there is no motor {motor}", WHERE, hint.lstrip())
    elif dof.kind == "slide" and "gear" not in parameters:
        text = f"the motor {motor} turns, but {dof.name} slides"
        entry = f"actuators: {{{yaml_key(dof.name)}: {{gear: ...}}}}"
        hint = f"give the turn of the motor per metre [rad/m]: {entry}"
        log.report("E-MOTOR", text, WHERE, hint)
    else:
        return True
    return False


def _incomplete(kind: str, parameters: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yields (problem, hint) for parameters that need other parameters, or exclude them."""
    if "imax" in parameters and "ki" not in parameters:
        yield "imax limits the integral part, which needs ki", "give ki"
    if "interp" in parameters and "delay" not in parameters:
        yield "interp applies to a delayed control, and there is no delay", "give delay"
    constants = [name for name in ("motorconst", "resistance") if name in parameters]
    if kind == "dcmotor" and "nominal" in parameters and constants:
        text = f"nominal replaces {' and '.join(constants)}"
        yield text, "give nominal, or motorconst and resistance"
    elif kind == "dcmotor" and "nominal" not in parameters and len(constants) < 2:
        yield "type dcmotor needs the constants of its motor", "give nominal, or motorconst and resistance"


def _check_dofs(glob: str, section: ActuatorSection, robot: Robot, log: Diagnostics) -> None:
    all_dofs = [(dof, "") for dof in robot.dofs]
    all_dofs += [(dof, loop.name) for loop in robot.loops for dof in loop.dofs]
    matched = [(dof, loop) for dof, loop in all_dofs if matches_glob(dof.name, glob)]
    if not matched:
        _report_unmatched(glob, robot, log)
        return
    exact = next(((dof, loop) for dof, loop in matched if dof.name == glob), None)
    if exact is not None and section.type != "none":
        dof, loop = exact
        if loop:
            text = f"{glob!r} closes a loop and is not a joint of the tree, so nothing can drive it"
            log.report("E-ACTUATOR", text, WHERE, "let another mate close the loop (loops.cut)")
        elif dof.kind not in ("turn", "slide"):
            kind = "ball" if dof.kind == "ball" else "free joint"
            text = f"{glob!r} is a {kind}: an actuator drives one turn or slide"
            log.report("E-ACTUATOR", text, WHERE, f"name one of: {_names(robot)}")


def _check_kinds(glob: str, choices: Mapping[str, ChosenActuator], robot: Robot, log: Diagnostics) -> None:
    """Reports parameters that an entry sets on both turns and slides (E-ACTUATOR)."""
    driven = [dof for dof in robot.dofs if dof.name in choices]
    ambiguous, example = [], {}
    for name in OF_ONE_KIND:
        kinds = {dof.kind: dof.name for dof in driven if _is_from(glob, name, choices[dof.name])}
        if {"turn", "slide"} <= set(kinds):
            ambiguous.append(name)
            example = kinds
    if ambiguous:
        text = (
            f"{glob!r} gives one {' and one '.join(ambiguous)} to turns ({example['turn']}, ...) and slides "
            f"({example['slide']}, ...), whose units differ"
        )
        numbers = ", ".join(f"{name}: ..." for name in ambiguous)
        entry = f"actuators: {{{yaml_key(example['slide'])}: {{{numbers}}}}}"
        log.report("E-ACTUATOR", text, WHERE, f"give them to each kind under its own glob: {entry}")


def _is_from(glob: str, name: str, choice: ChosenActuator) -> bool:
    """Returns whether the entry with this glob sets the parameter."""
    return name in choice.parameters and choice.origin[name] == glob


def _report_unmatched(glob: str, robot: Robot, log: Diagnostics) -> None:
    of_joint = [dof.name for joint in robot.joints if matches_glob(joint.name, glob) for dof in joint.dofs]
    if of_joint:
        text = f"{glob!r} names a joint of several dofs (or several such joints), not one dof"
        log.report("E-GLOB", text, WHERE, f"name one of its dofs: {', '.join(of_joint)}")
        return
    hint = no_match_hint(glob, {"joints": [dof.name for dof in robot.dofs]})
    log.report_unmatched("E-GLOB", f"no joint matches {glob!r}", WHERE, hint, glob)


def _names(robot: Robot) -> str:
    return name_list(dof.name for dof in robot.dofs if dof.kind in ("turn", "slide"))


def driven_order(robot: Robot, choices: Mapping[str, ChosenActuator], kept: Sequence[str]) -> list[str]:
    """Returns the dofs that may be driven, by priority: those with unchanged actuators of the source, those
    that an entry names, drivers of relations, and then the others from the root on; of dofs at the same
    distance from the root, the dof that moves the most mass comes first.

    `kept`: the dofs that keep the actuators of the source. Followers, and the passive joints of the source's
    SRDF, are left out unless an entry names them.
    """
    followers = {relation.follower for relation in robot.relations} | {*robot.semantics.passive}
    drivers = {relation.driver for relation in robot.relations}
    nearest = nearest_first(robot)
    chosen = [name for name in nearest if name in choices and choices[name].type != "none"]
    named = [name for name in chosen if choices[name].named]
    free = [name for name in chosen if name not in followers]
    drivers_of_relations = [name for name in free if name in drivers]
    return list(dict.fromkeys([*kept, *named, *drivers_of_relations, *free]))
