"""Makes actuators from their parameters, and estimates the parameters that are not set."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from linkwright.stages.export.actuators import gains
from linkwright.stages.export.actuators.choices import ChosenActuator
from linkwright.stages.export.actuators.holding import Holds
from linkwright.stages.export.actuators.loads import Load
from linkwright.stages.export.actuators.motors import Motors, OverriddenValue, parameters_with_motor
from linkwright.stages.export.actuators.ranges import control_range, with_keyframe_targets
from linkwright.stages.export.actuators.terms import terms_of
from linkwright.stages.robot.dynamics.holding_control import can_hold, holding_control
from linkwright.stages.robot.model.actuation import SERVOS, Actuator, ActuatorType, Armature
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS, children_of
from linkwright.stages.robot.model.robot import Dof, Robot, Value
from linkwright.stages.robot.motion.start_pose import HOME, keyframes
from linkwright.stages.robot.text.names import free_name


@dataclass(frozen=True, slots=True)
class TooStiffServo:
    """A servo that is too stiff for the time step with an armature no larger than the inertia that it
    moves."""

    dof: str

    kp: float
    """The stiffness [N m/rad or N/m] at the dof."""

    required_kp: float
    """The stiffness that the load requires or the user sets."""

    step: float
    """A time step [s] that is short enough for that stiffness."""


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
        extras = robot.mjcf or NO_EXTRAS
        sections = (*extras.sections, *extras.scene)
        # MuJoCo refuses two actuators of one name, also if the source's drives a tendon or an object.
        self._taken = {element.name for element in children_of(sections, "actuator")}
        self._timestep = timestep
        self._holds = holds
        self._poses = keyframes(robot)
        self.loads = loads
        self.armatures: list[Armature] = []
        self.overridden: list[OverriddenValue] = []
        self.too_stiff: list[TooStiffServo] = []

    def actuators(
        self, dofs: Sequence[Dof], choices: Mapping[str, ChosenActuator], kept: Sequence[Actuator]
    ) -> list[Actuator]:
        """Returns the actuators in the order of the dofs: for each dof the chosen actuator, or else those
        that it keeps from the source."""
        self._taken |= {actuator.name for actuator in kept}
        actuators: list[Actuator] = []
        for dof in dofs:
            if dof.name in choices:
                actuators.append(self._actuator_of(dof, choices[dof.name]))
            else:
                actuators += self._source_actuators(
                    dof, [actuator for actuator in kept if actuator.dof == dof.name]
                )
        return actuators

    def _actuator_of(self, dof: Dof, choice: ChosenActuator) -> Actuator:
        """Returns the actuator of a dof, with estimates for the parameters that are not set."""
        completed = parameters_with_motor(dof.name, choice, self._motors)
        parameters = completed.parameters
        self.overridden += completed.overridden
        gear = float(parameters.get("gear", 1.0))
        load = self.loads.get(dof.name)
        stiff = self._stiffness(dof, load, parameters, gear)
        armature = self._armature(dof, load, stiff)
        name = free_name(dof.name, self._taken)
        self._taken.add(name)
        actuator = Actuator(
            name=name,
            dof=dof.name,
            type=cast(ActuatorType, choice.type),
            gear=gear,
            force=parameters.get("forcerange"),
            terms=tuple(terms_of(choice.type, parameters, dof, gear, self._timestep)),
            load=None if load is None else load.largest_force,
            holds=self._holding_forces(dof, parameters.get("forcerange"), gear),
            motor=choice.motor,
            sources=completed.origins,
        )
        actuator = self._servo(actuator, dof, parameters, stiff, armature)
        if "ctrlrange" in parameters:
            actuator = replace(actuator, control=parameters["ctrlrange"])
        else:
            limits = control_range(dof, actuator, parameters)
            actuator = replace(
                actuator, control=with_keyframe_targets(limits, dof, actuator, self._values(dof.name))
            )
        return self._at_home(actuator)

    def _source_actuators(self, dof: Dof, actuators: Sequence[Actuator]) -> Iterator[Actuator]:
        """Yields the actuators of the source, with their loads and their controls at home. The first that can
        hold the dof holds it."""
        load = self.loads.get(dof.name)
        first = next((actuator for actuator in actuators if can_hold(actuator)), None)
        for actuator in actuators:
            forces = self._holding_forces(dof, actuator.force, actuator.gear) if actuator is first else ()
            yield self._at_home(
                replace(actuator, load=None if load is None else load.largest_force, holds=forces)
            )

    def _holding_forces(
        self, dof: Dof, force: tuple[float, float] | None, gear: float
    ) -> tuple[tuple[str, float], ...]:
        """Returns (keyframe, holding force), within the force range of the actuator and the effort of the
        dof."""
        effort = math.inf if dof.dynamics.effort is None else dof.dynamics.effort
        low, high = sorted(gear * end for end in force) if force is not None else (-effort, effort)
        low, high = max(low, -effort), min(high, effort)
        forces = self._holds.get(dof.name, {})
        return tuple((keyframe, min(max(needed, low), high)) for keyframe, needed in forces.items())

    def _stiffness(self, dof: Dof, load: Load | None, parameters: Mapping[str, Any], gear: float) -> float:
        """Returns the stiffness [N m/rad or N/m] at the dof, as set or estimated, and records a servo that is
        too stiff for the time step."""
        coupled = dof.name in self._coupled
        kp = parameters.get("kp")
        if load is None or dof.kind not in gains.SAG:
            return 1.0 if kp is None else float(kp) * gear**2
        largest_force = max_force_at_dof(dof, parameters.get("forcerange"), gear)
        effort = None if math.isinf(largest_force) else largest_force
        required = gains.stiffness(dof.kind, load, effort) or 1.0
        stiff = required if kp is None else float(kp) * gear**2
        if dof.dynamics.armature is not None:
            return stiff
        limit = gains.max_stiffness(load, self._timestep, coupled) or 1.0
        if stiff <= limit:
            return stiff
        softer = gains.rounded(limit) if kp is None else stiff
        if kp is not None or min(load.largest_force, largest_force) / softer > gains.SAG[dof.kind]:
            rigid = max(required, stiff)
            step = gains.longest_timestep(rigid, load, coupled)
            self.too_stiff.append(TooStiffServo(dof.name, softer, rigid, step))
        return softer

    def _armature(self, dof: Dof, load: Load | None, stiff: float) -> float:
        """Returns the armature [kg m² or kg] of a dof, and records it if it is estimated."""
        if dof.dynamics.armature is not None:
            return dof.dynamics.armature
        value = gains.armature(stiff, load, self._timestep, dof.name in self._coupled)
        self.armatures.append(Armature(dof.name, value, "driven"))
        return value

    def _servo(
        self, actuator: Actuator, dof: Dof, parameters: Mapping[str, Any], stiff: float, armature: float
    ) -> Actuator:
        """Returns the actuator with kp and kv, before the gear, as set or estimated. `stiff` [N m/rad or N/m]
        and `armature` [kg m² or kg]: at the dof."""
        estimated = []
        kp, kv = parameters.get("kp"), parameters.get("kv")
        load = self.loads.get(dof.name)
        estimated_armature = 0.0 if dof.dynamics.armature is not None else armature
        inertia = (load.inertia if load else 0.0) + estimated_armature
        if actuator.type in SERVOS:
            if kp is None:
                kp = gains.rounded(stiff / actuator.gear**2)
                estimated.append("kp")
            if kv is None:
                ratio = parameters.get("dampratio", 1.0)
                kv = gains.rounded(gains.damping(stiff, ratio, inertia) / actuator.gear**2)
                estimated.append("kv")
        elif actuator.type in ("velocity", "damper") and kv is None:
            effort = dof.dynamics.effort
            velocity_gain = (
                1.0 if load is None else gains.velocity_gain(dof.kind, load, estimated_armature, effort)
            )
            kv = gains.rounded(velocity_gain / actuator.gear**2)
            estimated.append("kv")
        else:
            kp = None
        return replace(actuator, kp=kp, kv=kv, estimated=tuple(estimated))

    def _values(self, dof: str) -> dict[str, Value]:
        """Returns the value of a dof in each keyframe."""
        return {name: pose[dof] for name, pose in self._poses.items()}

    def _at_home(self, actuator: Actuator) -> Actuator:
        """Returns the actuator with the control that holds its dof at `home`."""
        value = self._poses[HOME][actuator.dof]
        assert not isinstance(value, tuple)
        return replace(actuator, home=holding_control(actuator, value, actuator.force_at(HOME)))


def max_force_at_dof(dof: Dof, force: tuple[float, float] | None, gear: float) -> float:
    """Returns the largest force [N m or N] at the dof, by its effort and by the force range of its actuator
    (before the gear); infinite without either."""
    actuator_force = math.inf if force is None else max(map(abs, force)) * abs(gear)
    effort = dof.dynamics.effort
    return actuator_force if effort is None else min(actuator_force, effort)
