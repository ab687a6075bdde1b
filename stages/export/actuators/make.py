"""Actuators from what is wanted of them, with what is not given estimated."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from linkwright.stages.export.actuators import gains
from linkwright.stages.export.actuators.choices import Wanted
from linkwright.stages.export.actuators.holding import Holds
from linkwright.stages.export.actuators.loads import Load
from linkwright.stages.export.actuators.motors import Motors, Overruled, equipped
from linkwright.stages.export.actuators.ranges import control_range, widened
from linkwright.stages.export.actuators.terms import terms_of
from linkwright.stages.robot.dynamics.holding_control import can_hold, control_at
from linkwright.stages.robot.model.actuation import SERVOS, Actuator, ActuatorType, Armature
from linkwright.stages.robot.model.robot import Dof, Robot, Value
from linkwright.stages.robot.motion.start_pose import HOME, keyframes
from linkwright.stages.robot.text.names import free


@dataclass(frozen=True, slots=True)
class TooStiff:
    """A servo that is too stiff for the time step with an armature no larger than the inertia that it moves:
    its stiffness `kp` at the dof, the stiffness `asked` for, and the time step `step` [s] short enough for
    it."""

    dof: str
    kp: float
    asked: float
    step: float


class ActuatorMaker:
    """Makes actuators, and the armatures that they need."""

    def __init__(
        self,
        robot: Robot,
        timestep: float,
        loads: Mapping[str, Load],
        holds: Holds,
        coupled: Collection[str],
        motors: Motors,
    ) -> None:
        self._motors = motors
        self._coupled = coupled
        self._taken: set[str] = set()
        self._timestep = timestep
        self._holds = holds
        self._poses = keyframes(robot)
        self.loads = loads
        self.armatures: list[Armature] = []
        self.overruled: list[Overruled] = []
        self.too_stiff: list[TooStiff] = []

    def actuators(
        self, dofs: Sequence[Dof], wanted: Mapping[str, Wanted], kept: Sequence[Actuator]
    ) -> list[Actuator]:
        """In the order of the dofs: the actuator that is wanted of a dof, else those that it keeps of the
        source."""
        self._taken |= {actuator.name for actuator in kept}
        made: list[Actuator] = []
        for dof in dofs:
            if dof.name in wanted:
                made.append(self._made(dof, wanted[dof.name]))
            else:
                made += self._kept(dof, [actuator for actuator in kept if actuator.dof == dof.name])
        return made

    def _made(self, dof: Dof, wanted: Wanted) -> Actuator:
        """The actuator of a dof, with what is not given estimated."""
        equipment = equipped(dof.name, wanted, self._motors)
        given = equipment.parameters
        self.overruled += equipment.overruled
        gear = float(given.get("gear", 1.0))
        load = self.loads.get(dof.name)
        stiff = self._stiffness(dof, load, given, gear)
        armature = self._armature(dof, load, stiff)
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
            holds=self._held(dof, given.get("forcerange"), gear),
            motor=wanted.motor,
            sources=equipment.sources,
        )
        made = self._servo(made, dof, given, stiff, armature)
        if "ctrlrange" in given:
            made = replace(made, control=given["ctrlrange"])
        else:
            limits = control_range(dof, made, given)
            made = replace(made, control=widened(limits, dof, made, self._values(dof.name)))
        return self._at_home(made)

    def _kept(self, dof: Dof, actuators: Sequence[Actuator]) -> Iterator[Actuator]:
        """The actuators of the source, with their loads and their controls at home: of several that could,
        the first one holds the dof."""
        load = self.loads.get(dof.name)
        first = next((actuator for actuator in actuators if can_hold(actuator)), None)
        for actuator in actuators:
            held = self._held(dof, actuator.force, actuator.gear) if actuator is first else ()
            yield self._at_home(replace(actuator, load=None if load is None else load.most, holds=held))

    def _held(
        self, dof: Dof, force: tuple[float, float] | None, gear: float
    ) -> tuple[tuple[str, float], ...]:
        """The forces that hold the robot in its keyframes, as far as the actuator can make them."""
        most = math.inf if dof.dynamics.effort is None else dof.dynamics.effort
        low, high = sorted(gear * end for end in force) if force is not None else (-most, most)
        low, high = max(low, -most), min(high, most)
        forces = self._holds.get(dof.name, {})
        return tuple((keyframe, min(max(needed, low), high)) for keyframe, needed in forces.items())

    def _stiffness(self, dof: Dof, load: Load | None, given: Mapping[str, Any], gear: float) -> float:
        """At the dof: as given, else as estimated."""
        coupled = dof.name in self._coupled
        kp = given.get("kp")
        if load is None or dof.kind not in gains.SAG:
            return 1.0 if kp is None else float(kp) * gear**2
        most = strongest(dof, given.get("forcerange"), gear)
        effort = None if math.isinf(most) else most
        asked = gains.stiffness(dof.kind, load, effort) or 1.0
        stiff = asked if kp is None else float(kp) * gear**2
        if dof.dynamics.armature is not None:
            return stiff
        bearable = gains.bearable(load, self._timestep, coupled) or 1.0
        if stiff <= bearable:
            return stiff
        softer = gains.rounded(bearable) if kp is None else stiff
        if kp is not None or min(load.most, most) / softer > gains.SAG[dof.kind]:
            wanted = max(asked, stiff)
            step = gains.longest_step(wanted, load, coupled)
            self.too_stiff.append(TooStiff(dof.name, softer, wanted, step))
        return softer

    def _armature(self, dof: Dof, load: Load | None, stiff: float) -> float:
        if dof.dynamics.armature is not None:
            return dof.dynamics.armature
        value = gains.armature(stiff, load, self._timestep, dof.name in self._coupled)
        self.armatures.append(Armature(dof.name, value, "driven"))
        return value

    def _servo(
        self, made: Actuator, dof: Dof, given: Mapping[str, Any], stiff: float, armature: float
    ) -> Actuator:
        estimated = []
        kp, kv = given.get("kp"), given.get("kv")
        load = self.loads.get(dof.name)
        own = 0.0 if dof.dynamics.armature is not None else armature
        inertia = (load.inertia if load else 0.0) + own
        if made.type in SERVOS:
            if kp is None:
                kp = gains.rounded(stiff / made.gear**2)
                estimated.append("kp")
            if kv is None:
                ratio = given.get("dampratio", 1.0)
                kv = gains.rounded(gains.damping(stiff, ratio, inertia) / made.gear**2)
                estimated.append("kv")
        elif made.type in ("velocity", "damper") and kv is None:
            drag = 1.0 if load is None else gains.drag(dof.kind, load, own, dof.dynamics.effort)
            kv = gains.rounded(drag / made.gear**2)
            estimated.append("kv")
        else:
            kp = None
        return replace(made, kp=kp, kv=kv, estimated=tuple(estimated))

    def _values(self, dof: str) -> dict[str, Value]:
        """The value of a dof in each keyframe."""
        return {name: pose[dof] for name, pose in self._poses.items()}

    def _at_home(self, made: Actuator) -> Actuator:
        value = self._poses[HOME][made.dof]
        assert not isinstance(value, tuple)
        return replace(made, home=control_at(made, value, made.force_at(HOME)))


def strongest(dof: Dof, force: tuple[float, float] | None, gear: float) -> float:
    """The largest force [N m or N] at the dof, by its effort and by that of its actuator, before the gear;
    infinite without either."""
    own = math.inf if force is None else max(map(abs, force)) * abs(gear)
    effort = dof.dynamics.effort
    return own if effort is None else min(own, effort)
