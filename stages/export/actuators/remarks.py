"""Reports dofs that are not driven, and actuators that sag, are too weak or too stiff."""

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from linkwright.stages.export.actuators.choices import ChosenActuator
from linkwright.stages.export.actuators.make import ActuatorMaker, max_force_at_dof
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.motion.couplings import Rates
from linkwright.stages.robot.text.globs import name_list, yaml_key

WHERE = "actuators"

MAX_SAG = {"turn": 0.02, "slide": 0.002}
"""Sag [rad, m] at home beyond which a servo is reported."""

MAX_SPEED_AT_REST = 1e-9
"""Speed of a dof, for a unit speed of another, up to which it counts as at rest."""


def report_actuation(
    robot: Robot, actuation: Actuation, in_loops: Collection[str], undriven: Sequence[str], log: Diagnostics
) -> None:
    """Reports the dofs `undriven` that are not driven because other dofs of their loops are (I-ACTUATOR),
    servos that sag (W-ACTUATOR-SAG), and actuators that cannot hold the weight (W-ACTUATOR-EFFORT)."""
    if undriven:
        driven_in_loops = [actuator.dof for actuator in actuation.actuators if actuator.dof in in_loops]
        text = f"in closed loops these are driven: {name_list(driven_in_loops)}; "
        text += f"these follow: {name_list(undriven)}"
        example = driven_in_loops[0] if driven_in_loops else undriven[0]
        hint = f"to drive others, take one out: actuators: {{{yaml_key(example)}: none}}"
        log.report("I-ACTUATOR", text, WHERE, hint)
    dofs = {dof.name: dof for dof in robot.dofs}
    _report_sag(actuation, dofs, log)
    weak = [
        f"{actuator.name} ({actuator.load:.3g} of {largest_force:.3g})"
        for actuator in actuation.actuators
        if actuator.load is not None
        and actuator.load
        > (largest_force := max_force_at_dof(dofs[actuator.dof], actuator.force, actuator.gear))
    ]
    if weak:
        text = (
            f"somewhere in range the robot's weight [N m or N] exceeds what these can hold: {name_list(weak)}"
        )
        log.report("W-ACTUATOR-EFFORT", text, WHERE, "raise the effort (joints), or compensate (gravcomp)")


def report_couplings(
    robot: Robot, actuation: Actuation, rates: Mapping[str, Rates], chosen: Collection[str], log: Diagnostics
) -> None:
    """Reports dofs that are driven although other driven dofs move them (W-ACTUATOR-TWICE), and targets
    without a range at dofs that the limits of other dofs bound (I-ACTUATOR).

    `rates`: independently driven dof → the dofs that move with it, and their speeds; `chosen`: the dofs that
    the key `actuators` drives.
    """
    limits = {dof.name: dof.limits.interval for dof in robot.dofs if dof.kind in ("turn", "slide")}
    for actuator in (actuator for actuator in actuation.actuators if actuator.dof in chosen):
        movers = [
            name for name, moved in rates.items() if _moves(moved, actuator.dof) and name != actuator.dof
        ]
        if actuator.dof not in rates and movers:
            text = (
                f"{actuator.dof} is driven, although driven dofs already move it, by a loop or a relation: "
            )
            text += f"{name_list(movers)}. They can fight each other"
            if "kp" in actuator.estimated:
                text += f"; its kp of {actuator.kp:g} assumes no load, since {movers[0]} bears the weight"
            hint = f"drive one of the two: actuators: {{{yaml_key(movers[0])}: none}}"
            log.report("W-ACTUATOR-TWICE", text, WHERE, hint)
        bounding = _bounding_dofs(actuator.dof, rates, limits)
        if actuator.control is None and actuator.type in ("position", "pid") and bounding:
            text = f"{actuator.dof} has no limits of its own, so its control has no range; "
            text += f"other dofs that move with it have limits: {name_list(bounding)}"
            log.report(
                "I-ACTUATOR", text, WHERE, f"joints: {{{yaml_key(actuator.dof)}: {{limits: [..., ...]}}}}"
            )


def report_passive(
    robot: Robot, choices: Mapping[str, ChosenActuator], order: Sequence[str], log: Diagnostics
) -> None:
    """Reports dofs that entries match and that are not driven, because the source's SRDF calls them passive
    (I-ACTUATOR). `order`: the dofs that may be driven."""
    matched = [dof for dof in robot.semantics.passive if dof in choices and dof not in order]
    dofs = [dof for dof in matched if choices[dof].type != "none"]
    if dofs:
        text = f"passive joints of the source's SRDF have no actuator: {name_list(dofs)}"
        log.report(
            "I-ACTUATOR", text, WHERE, f"to drive one, name it: actuators: {{{yaml_key(dofs[0])}: ...}}"
        )


def _moves(moved: Rates, name: str) -> bool:
    """Returns whether the dof `name` is among the dofs that move, and does not rest."""
    return name in moved and bool(np.abs(moved[name]).max(initial=0.0) > MAX_SPEED_AT_REST)


def _bounding_dofs(
    name: str, rates: Mapping[str, Rates], limits: Mapping[str, tuple[float, float]]
) -> list[str]:
    """Returns the other dofs that move with the dof `name` and have two limits. `limits`: turn or slide →
    (lower, upper); infinite without a limit."""
    moved = rates.get(name, {})
    return [
        other
        for other in moved
        if other != name and _moves(moved, other) and all(map(math.isfinite, limits.get(other, (math.inf,))))
    ]


def _report_sag(actuation: Actuation, dofs: Mapping[str, Dof], log: Diagnostics) -> None:
    """Reports servos whose gain is set, and that the weight moves far from their target at `home`
    (W-ACTUATOR-SAG)."""
    sagging, kp_from_motor = [], set()
    for actuator in actuation.actuators:
        dof = dofs[actuator.dof]
        if (
            actuator.sag is None
            or dof.kind not in MAX_SAG
            or actuator.sag <= MAX_SAG[dof.kind]
            or "kp" in actuator.estimated
        ):
            continue
        unit = "rad" if dof.kind == "turn" else "m"
        largest_force = max_force_at_dof(dof, actuator.force, actuator.gear)
        limit = "no force limit" if math.isinf(largest_force) else f"force limit {largest_force:.3g}"
        cause = f"load {actuator.home_load:.3g}, {limit}, kp {actuator.kp:.3g}"
        sagging.append(f"{actuator.name} by {actuator.sag:.2g} {unit} ({cause})")
        kp_from_motor.add("kp" in dict(actuator.sources))
    if sagging:
        text = "at home the robot's weight moves servos from their targets [load in N m or N]"
        hint = "raise kp, or leave it out: it is estimated then"
        if kp_from_motor == {True}:
            hint = "these motors sag with their own kp: give another kp, or gravcomp"
        elif True in kp_from_motor:
            hint = "raise kp; some of these kp are the motors' own: give another kp, or gravcomp"
        log.report("W-ACTUATOR-SAG", f"{text}: {name_list(sagging)}", WHERE, hint)


def report_estimates(maker: ActuatorMaker, timestep: float, poses: int, log: Diagnostics) -> None:
    """Reports what bounded the estimates (I-SINGULAR, W-ARMATURE, I-ARMATURE, W-ACTUATOR-STEP). `poses`: the
    number of poses that sample the robot's range."""
    _report_singular(maker, poses, log)
    _report_armatures(maker, log)
    _report_steps(maker, timestep, log)


def _report_singular(maker: ActuatorMaker, poses: int, log: Diagnostics) -> None:
    """Reports the poses that are left out of a load (I-SINGULAR)."""
    values_left = {dof: load.left_out for dof, load in maker.loads.items() if load.left_out}
    if not values_left:
        return
    ranges = name_list(
        f"{dof} from {min(values):.4g} to {max(values):.4g} ({len(values)} of {poses} poses)"
        for dof, values in values_left.items()
    )
    text = (
        f"near a singular pose of its loop a dof has unlimited leverage; poses left out of its load: {ranges}"
    )
    dof = yaml_key(next(iter(values_left)))
    log.report("I-SINGULAR", text, WHERE, f"limits that avoid it: joints: {{{dof}: {{limits: [..., ...]}}}}")


def _report_armatures(maker: ActuatorMaker, log: Diagnostics) -> None:
    """Reports estimated armatures that exceed the inertia that the dof moves at home (W-ARMATURE), and the
    other estimated armatures (I-ARMATURE)."""
    large = [
        armature for armature in maker.armatures if armature.value > _inertia_at_home(maker, armature.dof)
    ]
    small = [armature for armature in maker.armatures if armature not in large]
    if large:
        listing = name_list(
            f"{armature.dof} ({armature.value:g}; moves {_inertia_at_home(maker, armature.dof):.3g})"
            for armature in large
        )
        text = "estimated armatures exceed the inertia that their joints move at home [kg m² or kg]"
        log.report("W-ARMATURE", f"{text}: {listing}", WHERE, _armature_key(large[0].dof))
    if small:
        added = name_list(f"{armature.dof} ({armature.value:g})" for armature in small)
        text = f"driven dofs without an armature got an estimated one [kg m² or kg]: {added}"
        log.report("I-ARMATURE", text, WHERE, _armature_key(small[0].dof))


def _report_steps(maker: ActuatorMaker, timestep: float, log: Diagnostics) -> None:
    """Reports servos for which the time step is too long (W-ACTUATOR-STEP)."""
    if not maker.too_stiff:
        return
    each = name_list(
        f"{servo.dof} (kp {servo.kp:.3g}; {servo.step:g} s is short enough for {servo.required_kp:.3g})"
        for servo in maker.too_stiff
    )
    text = (
        f"at a time step of {timestep:g} s these servos need an armature above the inertia they move: {each}"
    )
    hint = f"scene: {{option: {{timestep: {min(servo.step for servo in maker.too_stiff):g}}}}}"
    log.report("W-ACTUATOR-STEP", text, WHERE, f"{hint}, or {_armature_key(maker.too_stiff[0].dof)}")


def _inertia_at_home(maker: ActuatorMaker, dof: str) -> float:
    """Returns the inertia that a dof moves at home; infinite if it is unknown."""
    return maker.loads[dof].inertia if dof in maker.loads else math.inf


def _armature_key(dof: str) -> str:
    return f"joints: {{{yaml_key(dof)}: {{armature: ...}}}}"
