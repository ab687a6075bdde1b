"""Builds the actuation of a robot from the key `actuators` and the actuators of the source."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from linkwright.stages.export.actuators.choices import ChosenActuator, choose_actuators, driven_order
from linkwright.stages.export.actuators.holding import GroundSupports, keyframe_forces, no_supports
from linkwright.stages.export.actuators.loads import bounds_of, loads, postures, without_compensated_weight
from linkwright.stages.export.actuators.make import ActuatorMaker
from linkwright.stages.export.actuators.motors import Motors, motor_values, report_overridden
from linkwright.stages.export.actuators.remarks import (
    report_actuation,
    report_couplings,
    report_estimates,
    report_passive,
)
from linkwright.stages.export.actuators.symmetric_dofs import share_loads
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.driven import with_motors
from linkwright.stages.robot.dynamics.statics import GRAVITY
from linkwright.stages.robot.errors import Diagnostic, ExportError
from linkwright.stages.robot.model.actuation import Actuation, Actuator
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.motion.couplings import Couplings, Rates
from linkwright.stages.robot.motion.pose_batch import count_of
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.actuator_section import ActuatorSection

NO_MOTORS: Motors = {}
EVERY_GLOB_MATCHES: Mapping[Any, Sequence[str]] = {}


def actuate(
    robot: Robot,
    entries: Mapping[str, ActuatorSection],
    timestep: float,
    world_from_root: Array,
    gravity: Sequence[float] = GRAVITY,
    motors: Motors = NO_MOTORS,
    supports: GroundSupports = no_supports,
    optional: Mapping[Any, Sequence[str]] = EVERY_GLOB_MATCHES,
) -> tuple[Actuation, tuple[Diagnostic, ...]]:
    """Returns the actuation of the robot, and diagnostics. Raises ExportError with all problems of the key.

    `timestep` [s]: the time step of the simulation; `world_from_root` (4, 4): the pose of the robot in the
    scene; `gravity` (3,) [m/s²]: in the world; `motors`: the library that entries choose from; `supports`:
    the forces of the ground on a free robot; `optional`: the key of that name.
    """
    log = Diagnostics(optional=optional)
    choices = choose_actuators(robot, entries, motors, log)
    if log.problems:
        msg = f"the actuators cannot be made: {count(len(log.problems), 'problem')}"
        raise ExportError(
            msg, problems=sorted(log.problems, key=lambda problem: (problem.message, problem.where))
        )
    kept = [actuator for actuator in robot.actuators if actuator.dof not in choices]
    if not choices and not kept:
        return Actuation(), tuple(log.notes)
    values = postures(robot)
    couplings = Couplings(robot, values)
    order = driven_order(robot, choices, [actuator.dof for actuator in kept])
    chosen = couplings.independent(order)
    # A named dof is driven even if other driven dofs move it; `chosen` counts each motion only once.
    named = [dof for dof in order if dof not in choices or choices[dof].named]
    driven = [dof.name for dof in robot.dofs if dof.name in {*chosen, *named}]
    supply, overridden = motor_values([dof for dof in robot.dofs if dof.name in driven], choices, motors, log)
    robot = with_motors(robot, supply)
    up = -world_from_root[:3, :3].T @ gravity
    drivers = [dof for dof in driven if dof in chosen]
    rates = couplings.moved_by(drivers)
    shares = compensated_links(robot, choices, rates)
    bounds = bounds_of(robot, values, up, shares)
    shared_loads = share_loads(robot, loads(robot, values, couplings, drivers, up, bounds, shares))
    lightened = without_compensated_weight(robot, shares)
    holds = keyframe_forces(lightened, drivers, bounds, up, supports)
    maker = ActuatorMaker(robot, timestep, shared_loads, holds, couplings.coupled, motors)
    actuators = maker.actuators([dof for dof in robot.dofs if dof.name in driven], choices, kept)
    actuation = Actuation(
        # The controls of the source keep their order.
        actuators=tuple(sorted(actuators, key=_position_in(robot.actuators))),
        armatures=tuple(maker.armatures),
        compensated=tuple(sorted(shares.items())),
        compensating=tuple(dof for dof in driven if dof in choices and _share(choices[dof])),
        supplied=tuple(supply),
        overridden=tuple(dict.fromkeys(value.dof for value in overridden)),
    )
    report_overridden([*overridden, *maker.overridden], choices, log)
    report_actuation(robot, actuation, couplings.in_loops, [dof for dof in order if dof not in driven], log)
    report_estimates(maker, timestep, count_of(values), log)
    report_passive(robot, choices, order, log)
    report_couplings(robot, actuation, rates, [dof for dof in driven if dof in choices], log)
    return actuation, tuple(log.notes)


def _position_in(actuators: Sequence[Actuator]) -> Callable[[Actuator], int]:
    positions = {actuator.name: number for number, actuator in enumerate(actuators)}
    return lambda actuator: positions.get(actuator.name, len(positions))


def _share(choice: ChosenActuator) -> float:
    return float(choice.parameters.get("gravcomp") or 0.0)


def compensated_links(
    robot: Robot, choices: Mapping[str, ChosenActuator], rates: Mapping[str, Rates]
) -> dict[str, float]:
    """Returns, by link, the share of its weight that driven dofs compensate: the largest of those that move
    it."""
    owner = {dof.name: joint.child for joint in robot.joints for dof in joint.dofs}
    compensated: dict[str, float] = {}
    for name, moving_dofs in rates.items():
        share = _share(choices[name]) if name in choices else 0.0
        if not share:
            continue
        moved_links = {owner[dof] for dof, speeds in moving_dofs.items() if dof in owner and np.any(speeds)}
        for joint in robot.joints:
            if joint.child in moved_links or joint.parent in moved_links:
                moved_links.add(joint.child)
                compensated[joint.child] = max(compensated.get(joint.child, 0.0), share)
    return compensated
