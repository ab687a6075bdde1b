"""Diagnostics about what drives a robot."""

from collections.abc import Sequence

from stages.robot.actuation import Actuation, Actuator
from stages.robot.diagnostics import Diagnostics
from stages.robot.globs import listed
from stages.robot.model import Robot

WHERE = "actuators"


def remark(
    robot: Robot, actuation: Actuation, looped: Sequence[str], left: Sequence[str], log: Diagnostics
) -> None:
    """I-ACTUATOR for dofs that are not driven (`left`), since others of their closed loops are (`looped`);
    I-ARMATURE for armatures that were added; W-ACTUATOR-EFFORT where the weight is more than an actuator may
    hold."""
    if left:
        text = f"closed loops: driven are {listed(looped)}; these follow: {listed(left)}"
        out = looped[0] if looped else left[0]
        hint = f"to drive others, take one out: actuators: {{{out}: none}}"
        log.report("I-ACTUATOR", text, WHERE, hint)
    if actuation.armatures:
        added = listed(f"{one.dof} ({one.value:g})" for one in actuation.armatures)
        text = f"driven without an armature, which was estimated [kg m² or kg]: {added}"
        log.report("I-ARMATURE", text, WHERE, "joints: {" + actuation.armatures[0].dof + ": {armature: ...}}")
    effort = {dof.name: dof.dynamics.effort for dof in robot.dofs}
    weak = [
        f"{one.name} ({one.load:.3g} of {most:.3g})"
        for one in actuation.actuators
        if one.load is not None and (most := _most(one, effort[one.dof])) is not None and one.load > most
    ]
    if weak:
        text = f"somewhere in its range the robot weighs more [N m or N] than these may hold: {listed(weak)}"
        log.report("W-ACTUATOR-EFFORT", text, WHERE, "raise the effort (joints), or compensate (gravcomp)")


def _most(actuator: Actuator, effort: float | None) -> float | None:
    """The largest force at the dof."""
    own = None
    if actuator.force is not None:
        own = max(map(abs, actuator.force)) * abs(actuator.gear)
    bounds = [one for one in (own, effort) if one is not None]
    return min(bounds, default=None)
