"""From the key `actuators`, and the actuators that the source has, to what drives a robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from linkwright.stages.export.actuators.choices import Wanted, driven_order, wanted_of
from linkwright.stages.export.actuators.holding import GroundSupports, holding, standing_nowhere
from linkwright.stages.export.actuators.loads import bounds_of, lighter, loads, postures
from linkwright.stages.export.actuators.make import ActuatorMaker
from linkwright.stages.export.actuators.motors import Motors, report_overruled, supplied
from linkwright.stages.export.actuators.remarks import remark, remark_couplings, remark_passive, remark_servos
from linkwright.stages.export.actuators.symmetric_dofs import shared
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
    supports: GroundSupports = standing_nowhere,
    optional: Mapping[Any, Sequence[str]] = EVERY_GLOB_MATCHES,
) -> tuple[Actuation, tuple[Diagnostic, ...]]:
    """What drives the robot, and what is worth knowing about it. ExportError with all problems of the key.

    `timestep` [s]: that of the simulation; `world_from_root` (4, 4): how the scene puts the robot; `gravity`
    (3,) [m/s²]: in the world; `motors`: those that entries name; `supports`: what the ground carries of a
    free robot; `optional`: the key of that name.
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
    light = lighter(robot, shares)
    bounds = bounds_of(light, values, up)
    weighed = shared(robot, loads(light, values, couplings, drivers, up, bounds))
    holds = holding(light, drivers, bounds, up, supports)
    maker = ActuatorMaker(robot, timestep, weighed, holds, couplings.coupled, motors)
    actuators = maker.actuators([dof for dof in robot.dofs if dof.name in driven], wanted, kept)
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
    remark_servos(maker, timestep, count_of(values), log)
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
