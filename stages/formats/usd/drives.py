"""Converts actuators to drives of UsdPhysics, which has springs and dampers: the force at the dof is
stiffness · (target − position) + damping · (target speed − speed), within a largest force."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from linkwright.stages.robot.dynamics.holding_control import holding_state
from linkwright.stages.robot.model.actuation import SERVOS, Actuation, Actuator
from linkwright.stages.robot.model.robot import Configuration, Dof, Robot, Value
from linkwright.stages.robot.motion.start_pose import HOME

UNLIMITED = 1e9
"""Largest force of a drive without a limit [N m or N]: Newton's checks require a finite number."""


@dataclass(frozen=True, slots=True)
class Drive:
    """The drive of a turn or a slide, at the dof."""

    stiffness: float
    """[N m/rad or N/m]."""

    damping: float
    """[N m s/rad or N s/m]."""

    force: float | None
    """Largest force [N m or N]; None without a limit."""

    target: float = 0.0
    """Target at `home` [rad or m]."""


@dataclass(frozen=True, slots=True)
class Drives:
    """The drives of a robot."""

    by_dof: Mapping[str, Drive]
    """Dof → its drive."""

    left_out: tuple[str, ...]
    """The actuators that cannot be drives."""

    losses: tuple[tuple[str, str], ...]
    """(actuator, lost properties, in words) of the actuators that lose properties as drives."""


def drives_of(robot: Robot, actuation: Actuation, home: Configuration) -> Drives:
    """Returns the drives of a robot, with its dofs at `home`; of several actuators of a dof the first
    counts."""
    dofs = {dof.name: dof for joint in robot.joints for dof in joint.dofs if dof.kind in ("turn", "slide")}
    by_dof: dict[str, Drive] = {}
    left_out, losses = [], []
    for actuator in actuation.actuators:
        drive = (
            _drive(actuator, dofs[actuator.dof], home[actuator.dof])
            if actuator.dof in dofs and actuator.dof not in by_dof
            else None
        )
        if drive is None:
            left_out.append(actuator.name)
            continue
        by_dof[actuator.dof] = drive
        lost_properties = ", ".join(_lost_properties(actuator))
        if lost_properties:
            losses.append((actuator.name, lost_properties))
    followers = {relation.follower for relation in robot.relations if relation.follower in dofs}
    for name, dof in dofs.items():
        # A drive without gains does nothing, but holds the largest force for users who set gains. Checkers
        # take a joint without a drive for a mistake, except for a follower.
        if name not in by_dof and (dof.dynamics.effort is not None or name not in followers):
            by_dof[name] = Drive(0.0, 0.0, dof.dynamics.effort)
    return Drives(by_dof, tuple(left_out), tuple(losses))


def _drive(actuator: Actuator, dof: Dof, value: Value) -> Drive | None:
    """Returns the drive of an actuator at a value of its dof at `home`; None if it cannot be a drive.

    An actuator's length is the dof's value times its gear, and a force at the dof is the actuator's force
    times its gear: so gains at the dof are those of the actuator times the gear squared.
    """
    force = _largest_force(actuator, dof)
    if actuator.type in SERVOS:
        kp, kv = actuator.kp or 0.0, actuator.kv or 0.0
        assert not isinstance(value, tuple), "only turns and slides have drives"
        # The control of an intvelocity is a speed: its target is a state.
        target = (
            holding_state(actuator, value, actuator.force_at(HOME))[0]
            if actuator.type == "intvelocity"
            else actuator.home
        )
        return Drive(kp * actuator.gear**2, kv * actuator.gear**2, force, target / actuator.gear)
    if actuator.type == "velocity":
        return Drive(0.0, (actuator.kv or 0.0) * actuator.gear**2, force)
    return Drive(0.0, 0.0, force) if actuator.type == "motor" else None


def _largest_force(actuator: Actuator, dof: Dof) -> float | None:
    """Returns the largest force at the dof, the smallest of the actuator's limits and the dof's; None without
    a limit."""
    # The control of a motor is its force.
    ranges = [actuator.force, actuator.control if actuator.type == "motor" else None]
    limits = [max(map(abs, pair)) * abs(actuator.gear) for pair in ranges if pair is not None]
    if dof.dynamics.effort is not None:
        limits.append(dof.dynamics.effort)
    return min(limits, default=None)


def _lost_properties(actuator: Actuator) -> Iterator[str]:
    """Yields the properties, in words, that an actuator has and a drive cannot have."""
    names = [name for name, _ in actuator.terms]
    if "ki" in names:
        yield "integral part"
    if "slewmax" in names:
        yield "largest speed of the target"
    if "delay" in names:
        yield "delay"
    if actuator.force is not None and not math.isclose(-actuator.force[0], actuator.force[1]):
        yield "force range that is not symmetric"
