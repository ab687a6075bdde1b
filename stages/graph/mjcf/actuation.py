"""Reads the actuators and sensors of an MJCF, and renames the joints, sites and bodies that they refer to."""

from collections.abc import Callable, Iterator, Sequence
from typing import cast

from linkwright.stages.formats.mjcf.model import Mjcf, MjcfSensorEnd
from linkwright.stages.graph.mjcf.naming import MjcfFileNames
from linkwright.stages.robot.model.actuation import Actuator, ActuatorType
from linkwright.stages.robot.model.sensing import Sensor, SensorTarget, ZoneShape
from linkwright.stages.robot.text.names import free_name


def actuators_of(mjcf: Mjcf, names: MjcfFileNames) -> tuple[Actuator, ...]:
    """Returns the actuators; unnamed actuators get the names of their dofs."""
    dofs = _dof_names(mjcf, names)
    return tuple(
        Actuator(
            name=name,
            dof=dofs[actuator.joint],
            type=cast(ActuatorType, actuator.type),
            gear=actuator.gear,
            kp=actuator.kp,
            kv=actuator.kv,
            control=actuator.control,
            force=actuator.force,
            terms=actuator.terms,
        )
        for actuator, name in zip(mjcf.actuators, actuator_names(mjcf, names), strict=True)
    )


def sensors_of(mjcf: Mjcf, names: MjcfFileNames) -> tuple[Sensor, ...]:
    """Returns the sensors whose objects are in the robot; unnamed sensors get names."""
    sensors = []
    name_of = _end_names(mjcf, names)
    for sensor, name in zip(mjcf.sensors, sensor_names(mjcf, names), strict=True):
        target_name, reference_name = name_of(sensor.on), name_of(sensor.relative_to)
        if target_name is None or reference_name is None:
            continue
        sensors.append(
            Sensor(
                name=name,
                type=sensor.type,
                target=cast(SensorTarget, sensor.on.kind),
                name_of_target=target_name,
                relative_to=cast(SensorTarget, sensor.relative_to.kind),
                name_of_relative=reference_name,
                noise=sensor.noise,
                cutoff=sensor.cutoff,
                shape=cast(ZoneShape, sensor.shape),
                size=sensor.size,
            )
        )
    return tuple(sensors)


def sensor_names(mjcf: Mjcf, names: MjcfFileNames) -> list[str]:
    """Returns the names of all sensors: an unnamed sensor is called after its object."""
    name_of = _end_names(mjcf, names)
    proposals = [f"{name_of(sensor.on) or ''}_{sensor.type}".lstrip("_") for sensor in mjcf.sensors]
    return _completed_names([sensor.name for sensor in mjcf.sensors], proposals)


def actuator_names(mjcf: Mjcf, names: MjcfFileNames) -> list[str]:
    """Returns the names of all actuators: an unnamed actuator gets the name of its dof."""
    dofs = _dof_names(mjcf, names)
    return _completed_names(
        [actuator.name for actuator in mjcf.actuators], [dofs[actuator.joint] for actuator in mjcf.actuators]
    )


def _completed_names(file_names: Sequence[str], proposals: Sequence[str]) -> list[str]:
    """Returns the names of a file; each that is "" is replaced by its proposal, made unique."""
    taken_names = set(file_names)
    all_names = []
    for file_name, proposal in zip(file_names, proposals, strict=True):
        all_names.append(file_name or free_name(proposal, taken_names))
        taken_names.add(all_names[-1])
    return all_names


def _end_names(mjcf: Mjcf, names: MjcfFileNames) -> Callable[[MjcfSensorEnd], str | None]:
    """Returns a function that gives the robot's name for an end of a sensor: "" for an end without an object,
    None for a site that does not become a frame."""
    names_by_kind: dict[str, Sequence[str | None]] = {
        "joint": _dof_names(mjcf, names),
        "actuator": actuator_names(mjcf, names),
        "site": list(_frame_names(mjcf, names)),
        "body": [names.links[number] for number in range(len(mjcf.bodies))],
    }
    names_by_kind["xbody"] = names_by_kind["body"]
    return lambda end: names_by_kind[end.kind][end.number] if end.kind else ""


def _dof_names(mjcf: Mjcf, names: MjcfFileNames) -> list[str]:
    return [name for number in range(len(mjcf.bodies)) for name in names.dofs[number]]


def _frame_names(mjcf: Mjcf, names: MjcfFileNames) -> Iterator[str | None]:
    """Yields the names of the frames that sites become, None for other sites."""
    for number, body in enumerate(mjcf.bodies):
        for index in range(len(body.sites)):
            yield names.frames.get((number, index))
