"""What drives and measures the robot of a robot.json."""

from typing import Any, get_args

from stages.formats.robot_json.fields import Fields
from stages.robot.actuation import Actuation, Actuator, ActuatorType, Armature
from stages.robot.model import Sensor, Transmission
from stages.robot.sensing import Sensing, SensorCamera, SensorSite, SensorTarget, ZoneShape

TYPES, TARGETS, ZONES = get_args(ActuatorType), get_args(SensorTarget), get_args(ZoneShape)


def actuation_of(record: Fields) -> Actuation:
    """What drives the robot. What motors give the dofs these have already."""
    return Actuation(
        actuators=tuple(_actuator(one) for one in record.records("actuators")),
        armatures=tuple(
            Armature(one.text("dof"), one.number("value"), one.text("reason"))
            for one in record.records("armatures")
        ),
        compensated=tuple((one.text("link"), one.number("share")) for one in record.records("compensated")),
        compensating=record.texts("compensating") if record.has("compensating") else (),
    )


def sensing_of(record: Fields) -> Sensing:
    return Sensing(
        tuple(_sensor(one) for one in record.records("sensors")),
        tuple(_site(one) for one in record.records("sensor_sites")),
        tuple(_camera(one) for one in record.records("cameras")),
    )


def transmission_of(record: Fields) -> Transmission:
    name, joint, kind = (record.text(key) for key in ("name", "joint", "type"))
    return Transmission(name, joint, kind, record.number("reduction"), record.texts("interfaces"))


def _actuator(record: Fields) -> Actuator:
    forces = Fields(dict(record.items("holds")), f"{record.place}.holds")
    return Actuator(
        name=record.text("name"),
        dof=record.text("dof"),
        type=record.one_of("type", *TYPES),
        gear=record.number("gear"),
        kp=record.number_or_none("kp"),
        kv=record.number_or_none("kv"),
        control=_range(record, "control"),
        force=_range(record, "force"),
        terms=tuple((key, str(value)) for key, value in record.items("terms")),
        home=record.number("home"),
        load=record.number_or_none("load"),
        holds=tuple((name, forces.number(name)) for name in forces.table),
        estimated=record.texts("estimated"),
        motor=record.text("motor") if record.has("motor") else "",
        sources=tuple((key, str(value)) for key, value in record.items("provenance")),
    )


def _range(record: Fields, key: str) -> tuple[float, float] | None:
    if not record.has(key):
        return None
    low, high = record.numbers(key, 2)
    return low, high


def _sensor(record: Fields) -> Sensor:
    zone: dict[str, Any] = {}
    if record.has("shape"):
        zone = {"shape": record.one_of("shape", *ZONES), "size": record.numbers("size")}
    on, of = (_end(record, key) for key in ("on", "relative_to"))
    numbers = record.number("noise"), record.number("cutoff")
    return Sensor(record.text("name"), record.text("type"), *on, *of, *numbers, **zone)


def _end(record: Fields, key: str) -> tuple[Any, str]:
    if not record.has(key):
        return "", ""
    end = record.inside(key)
    return end.one_of("kind", *TARGETS), end.text("name")


def _site(record: Fields) -> SensorSite:
    where = record.text("name"), record.text("link"), record.pose("pose")
    if not record.has("shape"):
        return SensorSite(*where)
    return SensorSite(*where, record.one_of("shape", *ZONES), record.numbers("size"))


def _camera(record: Fields) -> SensorCamera:
    width, height = record.numbers("resolution", 2)
    where = record.text("name"), record.text("link"), record.pose("pose")
    return SensorCamera(*where, record.number("fovy"), (int(width), int(height)))
