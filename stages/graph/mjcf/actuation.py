"""Actuators and sensors of an MJCF, by the names that its joints, sites and bodies have now."""

from collections.abc import Iterator, Sequence
from typing import cast

from stages.formats.mjcf import Mjcf, MjcfSensorEnd
from stages.graph.mjcf.naming import MjcfFileNames
from stages.robot.actuation import Actuator, ActuatorType
from stages.robot.names import free
from stages.robot.sensing import Sensor, SensorTarget, ZoneShape


def actuators_of(mjcf: Mjcf, names: MjcfFileNames) -> tuple[Actuator, ...]:
    """The actuators; one without a name gets that of its dof."""
    dofs = _dofs(mjcf, names)
    called = _actuator_names(mjcf, names)
    return tuple(
        Actuator(
            name=name,
            dof=dofs[one.joint],
            type=cast(ActuatorType, one.type),
            gear=one.gear,
            kp=one.kp,
            kv=one.kv,
            control=one.control,
            force=one.force,
            terms=one.terms,
        )
        for one, name in zip(mjcf.actuators, called, strict=True)
    )


def sensors_of(mjcf: Mjcf, names: MjcfFileNames) -> tuple[Sensor, ...]:
    """The sensors whose objects have names now; one without a name gets one."""
    known: dict[str, Sequence[str | None]] = {
        "joint": _dofs(mjcf, names),
        "actuator": _actuator_names(mjcf, names),
        "site": list(_sites(mjcf, names)),
        "body": [names.links.get(number, "") for number in range(len(mjcf.bodies))],
    }
    known["xbody"] = known["body"]

    def name_of(end: MjcfSensorEnd) -> str | None:
        return known[end.kind][end.number] if end.kind else ""

    taken = {one.name for one in mjcf.sensors}
    found = []
    for one in mjcf.sensors:
        on, of = name_of(one.on), name_of(one.relative_to)
        if on is None or of is None:
            continue
        name = one.name or free(f"{on}_{one.type}".lstrip("_"), taken)
        taken.add(name)
        ends = (cast(SensorTarget, one.on.kind), on), (cast(SensorTarget, one.relative_to.kind), of)
        zone = cast(ZoneShape, one.shape), one.size
        found.append(Sensor(name, one.type, *ends[0], *ends[1], one.noise, one.cutoff, *zone))
    return tuple(found)


def _dofs(mjcf: Mjcf, names: MjcfFileNames) -> list[str]:
    return [name for number in range(len(mjcf.bodies)) for name in names.dofs[number]]


def _actuator_names(mjcf: Mjcf, names: MjcfFileNames) -> list[str]:
    dofs = _dofs(mjcf, names)
    taken = {one.name for one in mjcf.actuators}
    found = []
    for one in mjcf.actuators:
        found.append(one.name or free(dofs[one.joint], taken))
        taken.add(found[-1])
    return found


def _sites(mjcf: Mjcf, names: MjcfFileNames) -> Iterator[str | None]:
    """The frames, None for sites that are none."""
    for number, body in enumerate(mjcf.bodies):
        for index in range(len(body.sites)):
            yield names.frames.get((number, index))
