"""Actuators as drives of UsdPhysics, which has springs and dampers: the force at the dof is
stiffness · (target − position) + damping · (target speed − speed), within a largest force."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from linkwright.stages.robot.dynamics.holding_control import state_at
from linkwright.stages.robot.model.actuation import SERVOS, Actuation, Actuator
from linkwright.stages.robot.model.robot import Configuration, Dof, Robot, Value
from linkwright.stages.robot.motion.start_pose import HOME


@dataclass(frozen=True, slots=True)
class Drive:
    """What drives a turn or a slide, at the dof: `stiffness` [N m/rad or N/m], `damping` [N m s/rad or
    N s/m], `force` [N m or N] at most, None without a limit, and the `target` at `home` [rad or m]."""

    stiffness: float
    damping: float
    force: float | None
    target: float = 0.0


@dataclass(frozen=True, slots=True)
class Drives:
    """`of`: by dof. `left_out`: the actuators that are no drives; `less`: those that are drives, but with
    less than they have, each with what is lost."""

    of: Mapping[str, Drive]
    left_out: tuple[str, ...]
    less: tuple[tuple[str, str], ...]


def drives_of(robot: Robot, actuation: Actuation, home: Configuration) -> Drives:
    """The drives of a robot, with its dofs at `home`: of several actuators of one dof the first."""
    dofs = {dof.name: dof for joint in robot.joints for dof in joint.dofs if dof.kind in ("turn", "slide")}
    of: dict[str, Drive] = {}
    left_out, less = [], []
    for one in actuation.actuators:
        drive = _drive(one, dofs[one.dof], home[one.dof]) if one.dof in dofs and one.dof not in of else None
        if drive is None:
            left_out.append(one.name)
            continue
        of[one.dof] = drive
        lost = ", ".join(_lost(one))
        if lost:
            less.append((one.name, lost))
    for name, dof in dofs.items():
        # A drive without gains does nothing, but has the largest force for whoever gives it some.
        if name not in of and dof.dynamics.effort is not None:
            of[name] = Drive(0.0, 0.0, dof.dynamics.effort)
    return Drives(of, tuple(left_out), tuple(less))


def _drive(one: Actuator, dof: Dof, value: Value) -> Drive | None:
    """The drive of an actuator, None for one that is no drive. An actuator's length is the dof's value times
    its gear, and a force at the dof is that at the actuator times its gear."""
    force = _most(one, dof)
    if one.type in SERVOS:
        kp, kv = one.kp or 0.0, one.kv or 0.0
        assert not isinstance(value, tuple)
        # The control of an intvelocity is a speed: its target is a state.
        target = state_at(one, value, one.force_at(HOME))[0] if one.type == "intvelocity" else one.home
        return Drive(kp * one.gear**2, kv * one.gear**2, force, target / one.gear)
    if one.type == "velocity":
        return Drive(0.0, (one.kv or 0.0) * one.gear**2, force)
    return Drive(0.0, 0.0, force) if one.type == "motor" else None


def _most(one: Actuator, dof: Dof) -> float | None:
    """The largest force at the dof: of the actuator's, and of what the dof takes."""
    ends = [dof.dynamics.effort]
    ranges = [one.force, one.control if one.type == "motor" else None]
    ends += [max(map(abs, pair)) * abs(one.gear) for pair in ranges if pair is not None]
    return min((end for end in ends if end is not None), default=None)


def _lost(one: Actuator) -> Iterator[str]:
    names = [name for name, _ in one.terms]
    if "ki" in names:
        yield "integral part"
    if "slewmax" in names:
        yield "largest speed of the target"
    if "delay" in names:
        yield "delay"
    if one.force is not None and not math.isclose(-one.force[0], one.force[1]):
        yield "force range that is not symmetric"
