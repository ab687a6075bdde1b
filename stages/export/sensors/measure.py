"""Collects the sensors of a robot: those of the source, of the key `actuators`, and of the key `sensors`."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from linkwright.stages.export.sensors.mounted import MountedSensors
from linkwright.stages.export.sensors.of_dofs import actuator_sensors, joint_sensors, requested_sensors
from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.measuring import available_sensors
from linkwright.stages.robot.errors import Diagnostic, ExportError
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS, MjcfExtras, children_of
from linkwright.stages.robot.model.robot import Robot, Sensor
from linkwright.stages.robot.model.sensing import Sensing
from linkwright.stages.robot.text.names import plain
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections

OVERVIEW = "overview"
"""Name of the camera that the scene has by default."""


def sensing_of(
    robot: Robot,
    geometry: Geometry,
    actuation: Actuation,
    keys: "ExportSections",
    mjcf_form: MjcfForm,
) -> tuple[Sensing, tuple[Diagnostic, ...]]:
    """Returns the sensors of the source, of actuators, and of the key `sensors`, in this order, with
    diagnostics. Raises ExportError with all problems."""
    log = Diagnostics(optional=keys.optional)
    extras = mjcf_form.extras or NO_EXTRAS
    camera_places = {
        OVERVIEW: "scene.xml",
        **dict.fromkeys(_names_of_source(extras, "camera"), "the source"),
        **dict.fromkeys(keys.scene.cameras, "scene.cameras"),
    }
    site_names = set(_names_of_source(extras, "site"))
    mounted = MountedSensors(robot, geometry, mjcf_form.fused, site_names, camera_places, log)
    sensors = [("", mounted.of_source(source)) for source in available_sensors(robot, actuation)]
    sensors += requested_sensors(actuation, keys.actuators, log)
    for name, sensor in keys.sensors.items():
        where = f"sensors.{name}"
        if plain(name) != name:
            text = f"invalid name {name!r}: only letters without accents, digits and _ are allowed"
            log.report("E-SENSOR", text, where, f"for example {plain(name)}")
        elif sensor.type == "joint":
            sensors += ((where, measured) for measured in joint_sensors(name, sensor, robot, log))
        elif sensor.type == "actuator":
            sensors += (
                (where, measured) for measured in actuator_sensors(name, sensor, robot, actuation, log)
            )
        else:
            sensors += ((where, measured) for measured in mounted.sensors(name, sensor))
    sections = (*extras.sections, *extras.scene)
    _check_names(sensors, [element.name for element in children_of(sections, "sensor")], log)
    if log.problems:
        msg = f"the sensors cannot be made: {count(len(log.problems), 'problem')}"
        raise ExportError(
            msg, problems=sorted(log.problems, key=lambda problem: (problem.where, problem.message))
        )
    sensing = Sensing(
        tuple(measured for _, measured in sensors), tuple(mounted.sites), tuple(mounted.cameras)
    )
    return sensing, tuple(log.notes)


def _names_of_source(extras: MjcfExtras, tag: str) -> Iterator[str]:
    """Yields the names of the elements of this tag that only the MJCF has, on bodies and in the scene."""
    elements = [mount.element for mount in extras.mounted]
    elements += [element for section in extras.scene for element in section.inside()]
    yield from (element.name for element in elements if element.tag == tag)


def _check_names(
    sensors: Iterable[tuple[str, Sensor]], names_in_sections: Iterable[str], log: Diagnostics
) -> None:
    """Reports each name that two sensors have (E-SENSOR). `sensors`: the key of each sensor, "" for the
    source, and the sensor; `names_in_sections`: the sensors that only the MJCF has."""
    owners = dict.fromkeys(names_in_sections, "")
    for where, sensor in sensors:
        if sensor.name in owners:
            other = owners[sensor.name] or "the source"
            text = f"the sensor {sensor.name!r} is there already, from {other}"
            log.report("E-SENSOR", text, where, "give this entry another name")
        owners.setdefault(sensor.name, where)
