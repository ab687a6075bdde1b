"""From the key `actuators`, and the actuators that the source has, to what drives a robot."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from stages.export.actuators import estimates
from stages.export.actuators.alike import shared
from stages.export.actuators.choices import Wanted, driven_order, wanted_of
from stages.export.actuators.loads import Load, loads, postures
from stages.export.actuators.motors import Motors, Overruled, equipped, report_overruled, supplied
from stages.export.actuators.ranges import control_range
from stages.export.actuators.remarks import remark, remark_couplings, remark_passive
from stages.export.actuators.terms import terms_of
from stages.robot.actuation import SERVOS, Actuation, Actuator, ActuatorType, Armature
from stages.robot.couplings import Couplings, Rates
from stages.robot.diagnostics import Diagnostics
from stages.robot.driven import with_motors
from stages.robot.errors import Diagnostic, ExportError
from stages.robot.home_control import home_control
from stages.robot.model import Array, Dof, Robot, Value
from stages.robot.names import free
from stages.robot.plural import count
from stages.robot.start_pose import home
from stages.robot.statics import GRAVITY

if TYPE_CHECKING:
    from stages.export.actuator_keys import ActuatorKeys

NO_MOTORS: Motors = {}
EVERY_GLOB_MATCHES: Mapping[Any, Sequence[str]] = {}


def actuate(
    robot: Robot,
    entries: Mapping[str, ActuatorKeys],
    timestep: float,
    world_from_root: Array,
    gravity: Sequence[float] = GRAVITY,
    motors: Motors = NO_MOTORS,
    optional: Mapping[Any, Sequence[str]] = EVERY_GLOB_MATCHES,
) -> tuple[Actuation, tuple[Diagnostic, ...]]:
    """What drives the robot, and what is worth knowing about it. ExportError with all problems of the key.

    `timestep` [s]: that of the simulation; `world_from_root` (4, 4): how the scene puts the robot; `gravity`
    (3,) [m/s²]: in the world; `motors`: those that entries name; `optional`: the key of that name.
    """
    log = Diagnostics(optional=optional)
    wanted = wanted_of(robot, entries, motors, log)
    if log.problems:
        msg = f"the actuators cannot be made: {count(len(log.problems), 'problem')}"
        raise ExportError(msg, problems=sorted(log.problems, key=lambda one: (one.message, one.where)))
    kept = [one for one in robot.actuators if one.dof not in wanted]
    if not wanted and not kept:
        return Actuation(), tuple(log.found)
    values = postures(robot)
    couplings = Couplings(robot, values)
    order = driven_order(robot, wanted, [one.dof for one in kept])
    chosen = couplings.independent(order)
    # What is named drives, even where it fights others; those are still counted as one motion.
    named = [dof for dof in order if dof not in wanted or wanted[dof].named]
    driven = [dof.name for dof in robot.dofs if dof.name in {*chosen, *named}]
    gifts, overruled = supplied([dof for dof in robot.dofs if dof.name in driven], wanted, motors, log)
    robot = with_motors(robot, gifts)
    up = -world_from_root[:3, :3].T @ gravity
    drivers = [dof for dof in driven if dof in chosen]
    rates = couplings.moved_by(drivers)
    shares = compensated_links(robot, wanted, rates)
    found = shared(robot, loads(robot, values, couplings, drivers, shares, up))
    maker = _Maker(robot, timestep, found, {one.name for one in kept}, couplings.coupled, motors)
    actuators = [made for dof in robot.dofs if dof.name in driven for made in maker.of(dof, wanted, kept)]
    actuation = Actuation(
        # The controls of the source keep their order.
        actuators=tuple(sorted(actuators, key=_place_in(robot.actuators))),
        armatures=tuple(maker.armatures),
        compensated=tuple(sorted(shares.items())),
        compensating=tuple(dof for dof in driven if dof in wanted and _share(wanted[dof])),
        supplied=tuple(gifts),
        overruled=tuple(dict.fromkeys(loss.dof for loss in overruled)),
    )
    report_overruled([*overruled, *maker.overruled], wanted, log)
    remark(robot, actuation, couplings.in_loops, [dof for dof in order if dof not in driven], log)
    remark_passive(robot, wanted, order, log)
    remark_couplings(robot, actuation, rates, [one for one in driven if one in wanted], log)
    return actuation, tuple(log.found)


def _place_in(own: Sequence[Actuator]) -> Callable[[Actuator], int]:
    places = {one.name: number for number, one in enumerate(own)}
    return lambda one: places.get(one.name, len(places))


def _share(wanted: Wanted) -> float:
    return float(wanted.parameters.get("gravcomp") or 0.0)


def compensated_links(
    robot: Robot, wanted: Mapping[str, Wanted], rates: Mapping[str, Rates]
) -> dict[str, float]:
    """By link: the largest share of its weight that a driven dof that moves it compensates."""
    owner = {dof.name: joint.child for joint in robot.joints for dof in joint.dofs}
    found: dict[str, float] = {}
    for name, moving in rates.items():
        share = _share(wanted[name]) if name in wanted else 0.0
        if not share:
            continue
        moved = {owner[dof] for dof, speeds in moving.items() if dof in owner and np.any(speeds)}
        for joint in robot.joints:
            if joint.child in moved or joint.parent in moved:
                moved.add(joint.child)
                found[joint.child] = max(found.get(joint.child, 0.0), share)
    return found


class _Maker:
    """Makes actuators, and the armatures that they need."""

    def __init__(
        self,
        robot: Robot,
        timestep: float,
        found: Mapping[str, Load],
        taken: Collection[str],
        coupled: Collection[str],
        motors: Motors,
    ) -> None:
        self._motors = motors
        self._coupled = coupled
        self._taken = set(taken)
        self._timestep = timestep
        self._loads = found
        self._home = home(robot)
        self._fixed = robot.base.fixed
        self.armatures: list[Armature] = []
        self.overruled: list[Overruled] = []

    def of(self, dof: Dof, wanted: Mapping[str, Wanted], kept: Sequence[Actuator]) -> list[Actuator]:
        """The actuators of a dof: what is wanted, else those of the source that are kept."""
        if dof.name in wanted:
            return [self.made(dof, wanted[dof.name])]
        return [self.kept(dof, own) for own in kept if own.dof == dof.name]

    def made(self, dof: Dof, wanted: Wanted) -> Actuator:
        """The actuator of a dof, with what is not given estimated."""
        equipment = equipped(dof.name, wanted, self._motors)
        given = equipment.parameters
        self.overruled += equipment.overruled
        gear = float(given.get("gear", 1.0))
        load = self._loads.get(dof.name)
        stiff = self._stiffness(dof, load, given.get("kp"), gear)
        armature = self._armature(dof, stiff)
        name = free(dof.name, self._taken)
        self._taken.add(name)
        made = Actuator(
            name=name,
            dof=dof.name,
            type=cast(ActuatorType, wanted.type),
            gear=gear,
            force=given.get("forcerange"),
            terms=terms_of(wanted.type, given, dof, gear, self._timestep),
            load=None if load is None else load.most,
            home_load=None if load is None else abs(load.home),
            motor=wanted.motor,
            sources=equipment.sources,
        )
        made = self._servo(made, dof, given, stiff, armature)
        made = replace(made, control=given.get("ctrlrange") or control_range(dof, made, given))
        return self._at_home(made, load)

    def kept(self, dof: Dof, own: Actuator) -> Actuator:
        """An actuator of the source, with its load and its control at home."""
        load = self._loads.get(dof.name)
        weighed = replace(
            own,
            load=None if load is None else load.most,
            home_load=None if load is None else abs(load.home),
        )
        return self._at_home(weighed, load)

    def _stiffness(self, dof: Dof, load: Load | None, kp: float | None, gear: float) -> float:
        """At the dof: as given, else as estimated."""
        if kp is not None:
            return kp * gear**2
        if load is None or dof.kind not in estimates.SAG:
            return 1.0
        return estimates.stiffness(dof.kind, load, dof.dynamics.effort) or 1.0

    def _armature(self, dof: Dof, stiff: float) -> float:
        if dof.dynamics.armature is not None:
            return dof.dynamics.armature
        value = estimates.armature(stiff, self._timestep, dof.name in self._coupled)
        self.armatures.append(Armature(dof.name, value, "driven"))
        return value

    def _servo(
        self, made: Actuator, dof: Dof, given: Mapping[str, Any], stiff: float, armature: float
    ) -> Actuator:
        estimated = []
        kp, kv = given.get("kp"), given.get("kv")
        load = self._loads.get(dof.name)
        own = 0.0 if dof.dynamics.armature is not None else armature
        inertia = (load.inertia if load else 0.0) + own
        if made.type in SERVOS:
            if kp is None:
                kp = estimates.rounded(stiff / made.gear**2)
                estimated.append("kp")
            if kv is None:
                ratio = given.get("dampratio", 1.0)
                kv = estimates.rounded(estimates.damping(stiff, ratio, inertia) / made.gear**2)
                estimated.append("kv")
        elif made.type in ("velocity", "damper") and kv is None:
            drag = 1.0 if load is None else estimates.drag(dof.kind, load, own, dof.dynamics.effort)
            kv = estimates.rounded(drag / made.gear**2)
            estimated.append("kv")
        else:
            kp = None
        return replace(made, kp=kp, kv=kv, estimated=tuple(estimated))

    def _at_home(self, made: Actuator, load: Load | None) -> Actuator:
        value: Value = self._home[made.dof]
        force = load.home if load is not None and self._fixed else 0.0
        assert not isinstance(value, tuple)
        return replace(made, home=home_control(made, value, force))
