"""Diagnostics about what drives a robot."""

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from linkwright.stages.export.actuators.choices import Wanted
from linkwright.stages.export.actuators.make import ActuatorMaker, strongest
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.motion.couplings import Rates
from linkwright.stages.robot.text.globs import as_key, listed

WHERE = "actuators"

FAR = {"turn": 0.02, "slide": 0.002}
"""Sag [rad, m] at home from which on a servo is reported."""

STILL = 1e-9
"""The speed of a dof, for a unit speed of another, up to which it rests."""


def remark(
    robot: Robot, actuation: Actuation, in_loops: Collection[str], left: Sequence[str], log: Diagnostics
) -> None:
    """I-ACTUATOR for dofs that are not driven (`left`), since others of the dofs `in_loops` are;
    W-ACTUATOR-SAG for servos that sag; W-ACTUATOR-EFFORT where the weight is more than an actuator may
    hold."""
    if left:
        looped = [actuator.dof for actuator in actuation.actuators if actuator.dof in in_loops]
        text = f"closed loops: driven are {listed(looped)}; these follow: {listed(left)}"
        out = looped[0] if looped else left[0]
        hint = f"to drive others, take one out: actuators: {{{out}: none}}"
        log.report("I-ACTUATOR", text, WHERE, hint)
    dofs = {dof.name: dof for dof in robot.dofs}
    _report_sag(actuation, dofs, log)
    weak = [
        f"{one.name} ({one.load:.3g} of {most:.3g})"
        for one in actuation.actuators
        if one.load is not None and one.load > (most := strongest(dofs[one.dof], one.force, one.gear))
    ]
    if weak:
        text = f"somewhere in its range the robot weighs more [N m or N] than these may hold: {listed(weak)}"
        log.report("W-ACTUATOR-EFFORT", text, WHERE, "raise the effort (joints), or compensate (gravcomp)")


def remark_couplings(
    robot: Robot, actuation: Actuation, rates: Mapping[str, Rates], asked: Collection[str], log: Diagnostics
) -> None:
    """W-ACTUATOR-TWICE for dofs that are driven although other driven ones move them; I-ACTUATOR for targets
    without a range, where limits of other dofs bound the dof.

    `rates`: by the dofs that are driven independently of each other, what moves with them; `asked`: the dofs
    that the user drives.
    """
    limits = {dof.name: dof.limits.interval for dof in robot.dofs if dof.kind in ("turn", "slide")}
    for one in (one for one in actuation.actuators if one.dof in asked):
        others = [name for name, moved in rates.items() if _moves(moved, one.dof) and name != one.dof]
        if one.dof not in rates and others:
            text = f"{one.dof} is driven, and so is what moves it already, by a loop or a relation: "
            text += f"{listed(others)}. The two can fight each other"
            if "kp" in one.estimated:
                text += f"; its kp of {one.kp:g} stands for no load, since {others[0]} bears the weight"
            hint = f"drive one of the two: actuators: {{{as_key(others[0])}: none}}"
            log.report("W-ACTUATOR-TWICE", text, WHERE, hint)
        bounding = _bounding(one.dof, rates, limits)
        if one.control is None and one.type in ("position", "pid") and bounding:
            text = (
                f"{one.dof} has no limits of its own, so its control has no range; bounded by limits that it "
            )
            text += f"moves with: {listed(bounding)}"
            log.report("I-ACTUATOR", text, WHERE, f"joints: {{{as_key(one.dof)}: {{limits: [..., ...]}}}}")


def remark_passive(
    robot: Robot, wanted: Mapping[str, Wanted], order: Sequence[str], log: Diagnostics
) -> None:
    """I-ACTUATOR for dofs that entries match and that are not driven, since the source's SRDF calls them
    passive. `order`: the dofs that may be driven."""
    matched = [dof for dof in robot.semantics.passive if dof in wanted and dof not in order]
    dofs = [dof for dof in matched if wanted[dof].type != "none"]
    if dofs:
        text = f"passive joints of the source's SRDF have no actuator: {listed(dofs)}"
        log.report("I-ACTUATOR", text, WHERE, f"to drive one, name it: actuators: {{{as_key(dofs[0])}: ...}}")


def _moves(moved: Rates, name: str) -> bool:
    return name in moved and bool(np.abs(moved[name]).max(initial=0.0) > STILL)


def _bounding(name: str, rates: Mapping[str, Rates], limits: Mapping[str, tuple[float, float]]) -> list[str]:
    """The dofs with two limits that move with this one."""
    moved = rates.get(name, {})
    return [
        other
        for other in moved
        if other != name and _moves(moved, other) and all(map(math.isfinite, limits.get(other, (math.inf,))))
    ]


def _report_sag(actuation: Actuation, dofs: Mapping[str, Dof], log: Diagnostics) -> None:
    """W-ACTUATOR-SAG for servos whose gain is given, and that the weight moves far from a target at
    `home`."""
    far, by_motor = [], set()
    for one in actuation.actuators:
        dof = dofs[one.dof]
        if one.sag is None or dof.kind not in FAR or one.sag <= FAR[dof.kind] or "kp" in one.estimated:
            continue
        unit = "rad" if dof.kind == "turn" else "m"
        most = strongest(dof, one.force, one.gear)
        limit = "no force limit" if math.isinf(most) else f"force limit {most:.3g}"
        far.append(f"{one.name} by {one.sag:.2g} {unit} (load {one.home_load:.3g}, {limit}, kp {one.kp:.3g})")
        by_motor.add("kp" in dict(one.sources))
    if far:
        text = f"at home the robot's weight moves servos from their targets [load in N m or N]: {listed(far)}"
        hint = "raise kp, or leave it out: it is estimated then"
        if by_motor == {True}:
            hint = "so do these motors with their own kp; give another one, or gravcomp"
        elif True in by_motor:
            hint = "raise kp; where a motor gives it, so does the motor: give another one, or gravcomp"
        log.report("W-ACTUATOR-SAG", text, WHERE, hint)


def remark_servos(maker: ActuatorMaker, timestep: float, poses: int, log: Diagnostics) -> None:
    """I-SINGULAR, W-ARMATURE, I-ARMATURE and W-ACTUATOR-STEP: what bounded the estimates. `poses`: how many
    poses stand for the robot's range."""
    _report_singular(maker, poses, log)
    _report_armatures(maker, log)
    _report_steps(maker, timestep, log)


def _report_singular(maker: ActuatorMaker, poses: int, log: Diagnostics) -> None:
    """I-SINGULAR for poses that did not count for a load."""
    values_left = {dof: load.left_out for dof, load in maker.loads.items() if load.left_out}
    if not values_left:
        return
    near = listed(
        f"{dof} from {min(values):.4g} to {max(values):.4g} ({len(values)} of {poses} poses)"
        for dof, values in values_left.items()
    )
    text = f"near a singular pose of its loop a dof has a leverage without end; left out of its load: {near}"
    dof = as_key(next(iter(values_left)))
    log.report("I-SINGULAR", text, WHERE, f"limits that avoid it: joints: {{{dof}: {{limits: [..., ...]}}}}")


def _report_armatures(maker: ActuatorMaker, log: Diagnostics) -> None:
    """W-ARMATURE for estimated armatures that are larger than what the dof moves at home, I-ARMATURE for the
    rest."""
    large = [armature for armature in maker.armatures if armature.value > _moved(maker, armature.dof)]
    small = [armature for armature in maker.armatures if armature not in large]
    if large:
        each = listed(
            f"{armature.dof} ({armature.value:g}; moves {_moved(maker, armature.dof):.3g})"
            for armature in large
        )
        text = "estimated armatures exceed the inertia that their joints move at home [kg m² or kg]"
        log.report("W-ARMATURE", f"{text}: {each}", WHERE, _armature_of(large[0].dof))
    if small:
        added = listed(f"{armature.dof} ({armature.value:g})" for armature in small)
        text = f"driven without an armature, which was estimated [kg m² or kg]: {added}"
        log.report("I-ARMATURE", text, WHERE, _armature_of(small[0].dof))


def _report_steps(maker: ActuatorMaker, timestep: float, log: Diagnostics) -> None:
    """W-ACTUATOR-STEP for servos for which the time step is too long."""
    if not maker.too_stiff:
        return
    each = listed(
        f"{servo.dof} (kp {servo.kp:.3g}; {servo.step:g} s is short enough for {servo.asked:.3g})"
        for servo in maker.too_stiff
    )
    text = (
        f"at a time step of {timestep:g} s these servos need an armature larger than what they move: {each}"
    )
    hint = f"scene: {{option: {{timestep: {min(servo.step for servo in maker.too_stiff):g}}}}}"
    log.report("W-ACTUATOR-STEP", text, WHERE, f"{hint}, or {_armature_of(maker.too_stiff[0].dof)}")


def _moved(maker: ActuatorMaker, dof: str) -> float:
    """The inertia that a dof moves at home; infinite where it is unknown."""
    return maker.loads[dof].inertia if dof in maker.loads else math.inf


def _armature_of(dof: str) -> str:
    return f"joints: {{{as_key(dof)}: {{armature: ...}}}}"
