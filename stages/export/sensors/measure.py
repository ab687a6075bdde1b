"""From the keys `sensors` and `actuators`, and the sensors that the source has, to what measures a robot."""

from collections.abc import Collection
from typing import TYPE_CHECKING

from linkwright.stages.export.sensors.mounted import Mounted
from linkwright.stages.export.sensors.of_dofs import actuator_sensors, encoders, joint_sensors
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.measuring import measuring
from linkwright.stages.robot.errors import Diagnostic, ExportError
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot, Sensor
from linkwright.stages.robot.model.sensing import Sensing
from linkwright.stages.robot.text.names import plain
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections

OVERVIEW = "overview"
"""The camera that every scene has."""


def sensing_of(
    robot: Robot,
    geometry: Geometry,
    actuation: Actuation,
    keys: "ExportSections",
    fused: Collection[str] = (),
) -> tuple[Sensing, tuple[Diagnostic, ...]]:
    """What measures the robot: the sensors of the source, those of actuators, and those of the key, in this
    order; and what is worth knowing about it. `fused`: the links without bodies of their own in the MJCF.
    ExportError with all problems."""
    log = Diagnostics(optional=keys.optional)
    made = Mounted(robot, geometry, fused, {*keys.scene.cameras, OVERVIEW}, log)
    found = [("", made.of_source(one)) for one in measuring(robot, actuation)]
    found += encoders(actuation, keys.actuators, log)
    for name, sensor in keys.sensors.items():
        where = f"sensors.{name}"
        if plain(name) != name:
            text = f"invalid name {name!r}: only letters without accents, digits and _ are allowed"
            log.report("E-SENSOR", text, where, f"for example {plain(name)}")
        elif sensor.type == "joint":
            found += ((where, one) for one in joint_sensors(name, sensor, robot, log))
        elif sensor.type == "actuator":
            found += ((where, one) for one in actuator_sensors(name, sensor, robot, actuation, log))
        else:
            found += ((where, one) for one in made.sensors(name, sensor))
    _check_names(found, log)
    if log.problems:
        msg = f"the sensors cannot be made: {count(len(log.problems), 'problem')}"
        raise ExportError(msg, problems=sorted(log.problems, key=lambda one: (one.where, one.message)))
    sensing = Sensing(tuple(one for _, one in found), tuple(made.sites), tuple(made.cameras))
    return sensing, tuple(log.found)


def _check_names(found: list[tuple[str, Sensor]], log: Diagnostics) -> None:
    """E-SENSOR for each name that two sensors have."""
    owners: dict[str, str] = {}
    for where, one in found:
        if one.name in owners:
            other = owners[one.name] or "the source"
            text = f"the sensor {one.name!r} is there already, from {other}"
            log.report("E-SENSOR", text, where, "give this entry another name")
        owners.setdefault(one.name, where)
