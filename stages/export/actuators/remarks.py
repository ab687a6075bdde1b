"""Diagnostics about what drives a robot."""

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from stages.export.actuators.choices import Wanted
from stages.robot.actuation import Actuation, Actuator
from stages.robot.couplings import Rates
from stages.robot.diagnostics import Diagnostics
from stages.robot.globs import as_key, listed
from stages.robot.model import Robot

WHERE = "actuators"

FAR = {"turn": 0.02, "slide": 0.002}
"""Sag [rad, m] at home from which on a servo is reported."""

STILL = 1e-9
"""The speed of a dof, for a unit speed of another, up to which it rests."""


def remark(
    robot: Robot, actuation: Actuation, in_loops: Collection[str], left: Sequence[str], log: Diagnostics
) -> None:
    """I-ACTUATOR for dofs that are not driven (`left`), since others of the dofs `in_loops` are;
    I-ARMATURE for armatures that were added; W-ACTUATOR-SAG for servos that sag; W-ACTUATOR-EFFORT where the
    weight is more than an actuator may hold."""
    if left:
        looped = [actuator.dof for actuator in actuation.actuators if actuator.dof in in_loops]
        text = f"closed loops: driven are {listed(looped)}; these follow: {listed(left)}"
        out = looped[0] if looped else left[0]
        hint = f"to drive others, take one out: actuators: {{{out}: none}}"
        log.report("I-ACTUATOR", text, WHERE, hint)
    if actuation.armatures:
        added = listed(f"{one.dof} ({one.value:g})" for one in actuation.armatures)
        text = f"driven without an armature, which was estimated [kg m² or kg]: {added}"
        log.report("I-ARMATURE", text, WHERE, "joints: {" + actuation.armatures[0].dof + ": {armature: ...}}")
    _report_sag(actuation, robot, log)
    effort = {dof.name: dof.dynamics.effort for dof in robot.dofs}
    weak = [
        f"{one.name} ({one.load:.3g} of {most:.3g})"
        for one in actuation.actuators
        if one.load is not None and (most := _most(one, effort[one.dof])) is not None and one.load > most
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


def _report_sag(actuation: Actuation, robot: Robot, log: Diagnostics) -> None:
    """W-ACTUATOR-SAG for servos that the weight moves far from `home`."""
    dofs = {dof.name: dof for dof in robot.dofs}
    far, by_motor = [], set()
    for one in actuation.actuators:
        kind, effort = dofs[one.dof].kind, dofs[one.dof].dynamics.effort
        if one.sag is None or kind not in FAR or one.sag <= FAR[kind]:
            continue
        unit = "rad" if kind == "turn" else "m"
        most = _most(one, effort)
        limit = "no force limit" if most is None else f"force limit {most:.3g}"
        far.append(f"{one.name} by {one.sag:.2g} {unit} (load {one.home_load:.3g}, {limit}, kp {one.kp:.3g})")
        by_motor.add("kp" in dict(one.sources))
    if far:
        text = f"the robot's weight moves servos from home [load in N m or N]: {listed(far)}"
        hint = "raise kp, or leave it out: it is estimated then"
        if by_motor == {True}:
            hint = "so do these motors with their own kp; give another one, or gravcomp"
        elif True in by_motor:
            hint = "raise kp; where a motor gives it, so does the motor: give another one, or gravcomp"
        log.report("W-ACTUATOR-SAG", text, WHERE, hint)


def _most(actuator: Actuator, effort: float | None) -> float | None:
    """The largest force at the dof."""
    own = None
    if actuator.force is not None:
        own = max(map(abs, actuator.force)) * abs(actuator.gear)
    bounds = [one for one in (own, effort) if one is not None]
    return min(bounds, default=None)
