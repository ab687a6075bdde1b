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
NO_OPTIONAL_GLOBS: Mapping[Any, Sequence[str]] = {}
"""Key → its globs that may match nothing."""


def actuate(
    robot: Robot,
    entries: Mapping[str, ActuatorSection],
    timestep: float,
    world_from_root: Array,
    gravity: Sequence[float] = GRAVITY,
    motors: Motors = NO_MOTORS,
    supports: GroundSupports = no_supports,
    optional: Mapping[Any, Sequence[str]] = NO_OPTIONAL_GLOBS,
) -> tuple[Actuation, tuple[Diagnostic, ...]]:
    """Returns the actuation of the robot, and diagnostics. Raises ExportError with all problems of the key.

    `entries`: glob of dofs → their actuator, where later entries override earlier ones; `timestep` [s]: the
    time step of the simulation; `world_from_root` (4, 4): the pose of the robot in the scene;
    `gravity` (3,) [m/s²]: in the world; `motors`: the library that entries choose from; `supports`:
    the forces of the ground on a free robot; `optional`: key → its globs that may match nothing.
    """
    log = Diagnostics(optional=optional)
    choices = choose_actuators(robot, entries, motors, log)
    _refuse_problems(log)
    kept = [actuator for actuator in robot.actuators if actuator.dof not in choices]
    if not choices and not kept:
        return Actuation(), tuple(log.notes)
    values = postures(robot)
    couplings = Couplings(robot, values)
    order = driven_order(robot, choices, [actuator.dof for actuator in kept])
    independent = couplings.independent(order)
    # A named dof is driven even if other driven dofs move it; `independent` has each motion only once.
    named = [dof for dof in order if dof not in choices or choices[dof].named]
    driven = [dof.name for dof in robot.dofs if dof.name in {*independent, *named}]
    supply, overridden = motor_values([dof for dof in robot.dofs if dof.name in driven], choices, motors, log)
    # The dofs have the inertia, damping and limits of their motors from here on.
    robot = with_motors(robot, supply)
    # Against gravity, in the root link's axes.
    up = -world_from_root[:3, :3].T @ gravity
    independent_driven = [dof for dof in driven if dof in independent]
    rates = couplings.moved_by(independent_driven)
    shares = compensated_links(robot, choices, rates)
    bounds = bounds_of(robot, values, up, shares)
    lightened = without_compensated_weight(robot, shares)
    own_loads = loads(robot, values, couplings, independent_driven, up, bounds, lightened)
    shared_loads = share_loads(robot, own_loads)
    holds = keyframe_forces(lightened, independent_driven, bounds, up, supports)
    maker = ActuatorMaker(robot, timestep, shared_loads, holds, couplings.coupled, motors)
    actuators = maker.actuators([dof for dof in robot.dofs if dof.name in driven], choices, kept)
    actuation = Actuation(
        # The controls of the source keep their order.
        actuators=tuple(sorted(actuators, key=_in_order_of(robot.actuators))),
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


def _refuse_problems(log: Diagnostics) -> None:
    """Raises ExportError with all problems, if there are any."""
    if log.problems:
        message = f"the actuators cannot be made: {count(len(log.problems), 'problem')}"
        problems = sorted(log.problems, key=lambda problem: (problem.message, problem.where))
        raise ExportError(message, problems=problems)


def _in_order_of(actuators: Sequence[Actuator]) -> Callable[[Actuator], int]:
    """Returns a sort key: an actuator's position among these actuators by its name, others after them."""
    positions = {actuator.name: number for number, actuator in enumerate(actuators)}
    return lambda actuator: positions.get(actuator.name, len(positions))


def _share(choice: ChosenActuator) -> float:
    """Returns the share [-] of the weight that an actuator compensates."""
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
        # Parents come before their children.
        for joint in robot.joints:
            if joint.child in moved_links or joint.parent in moved_links:
                moved_links.add(joint.child)
                compensated[joint.child] = max(compensated.get(joint.child, 0.0), share)
    return compensated
