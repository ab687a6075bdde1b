"""Actuators and sensors of an MJCF, by the names that its joints, sites and bodies have now."""

from collections.abc import Callable, Iterator, Sequence
from typing import cast

from linkwright.stages.formats.mjcf.model import Mjcf, MjcfSensorEnd
from linkwright.stages.graph.mjcf.naming import MjcfFileNames
from linkwright.stages.robot.model.actuation import Actuator, ActuatorType
from linkwright.stages.robot.model.sensing import Sensor, SensorTarget, ZoneShape
from linkwright.stages.robot.text.names import free


def actuators_of(mjcf: Mjcf, names: MjcfFileNames) -> tuple[Actuator, ...]:
    """The actuators; one without a name gets that of its dof."""
    dofs = _dofs(mjcf, names)
    called = actuator_names(mjcf, names)
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
        for actuator, name in zip(mjcf.actuators, called, strict=True)
    )


def sensors_of(mjcf: Mjcf, names: MjcfFileNames) -> tuple[Sensor, ...]:
    """The sensors whose objects have names now; one without a name gets one."""
    found = []
    name_of = _namer(mjcf, names)
    for sensor, name in zip(mjcf.sensors, sensor_names(mjcf, names), strict=True):
        on, of = name_of(sensor.on), name_of(sensor.relative_to)
        if on is None or of is None:
            continue
        ends = (cast(SensorTarget, sensor.on.kind), on), (cast(SensorTarget, sensor.relative_to.kind), of)
        zone = cast(ZoneShape, sensor.shape), sensor.size
        found.append(Sensor(name, sensor.type, *ends[0], *ends[1], sensor.noise, sensor.cutoff, *zone))
    return tuple(found)


def sensor_names(mjcf: Mjcf, names: MjcfFileNames) -> list[str]:
    """The names of all sensors: one without a name is called after what it is on."""
    taken, name_of = {sensor.name for sensor in mjcf.sensors}, _namer(mjcf, names)
    found = []
    for sensor in mjcf.sensors:
        on = name_of(sensor.on) or ""
        found.append(sensor.name or free(f"{on}_{sensor.type}".lstrip("_"), taken))
        taken.add(found[-1])
    return found


def actuator_names(mjcf: Mjcf, names: MjcfFileNames) -> list[str]:
    """The names of all actuators."""
    dofs = _dofs(mjcf, names)
    taken = {actuator.name for actuator in mjcf.actuators}
    found = []
    for actuator in mjcf.actuators:
        found.append(actuator.name or free(dofs[actuator.joint], taken))
        taken.add(found[-1])
    return found


def _namer(mjcf: Mjcf, names: MjcfFileNames) -> Callable[[MjcfSensorEnd], str | None]:
    """What gives the name of a sensor's end, "" for nothing; None for a site that is no frame."""
    named: dict[str, Sequence[str | None]] = {
        "joint": _dofs(mjcf, names),
        "actuator": actuator_names(mjcf, names),
        "site": list(_sites(mjcf, names)),
        "body": [names.links.get(number, "") for number in range(len(mjcf.bodies))],
    }
    named["xbody"] = named["body"]
    return lambda end: named[end.kind][end.number] if end.kind else ""


def _dofs(mjcf: Mjcf, names: MjcfFileNames) -> list[str]:
    return [name for number in range(len(mjcf.bodies)) for name in names.dofs[number]]


def _sites(mjcf: Mjcf, names: MjcfFileNames) -> Iterator[str | None]:
    """The frames, None for sites that are none."""
    for number, body in enumerate(mjcf.bodies):
        for index in range(len(body.sites)):
            yield names.frames.get((number, index))
