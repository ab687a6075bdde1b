"""What robot.json says of actuators and sensors."""

from typing import Any

from stages.export.json_values import as_float, as_floats, as_pose, short
from stages.formats.numbers import FORCE, TURN
from stages.robot.actuation import Actuation, Actuator
from stages.robot.model import Sensor
from stages.robot.sensing import Sensing, SensorCamera, SensorSite


def _actuator(actuator: Actuator) -> dict[str, Any]:
    return {
        "name": actuator.name,
        "dof": actuator.dof,
        "type": actuator.type,
        "gear": as_float(actuator.gear),
        "kp": as_float(actuator.kp),
        "kv": as_float(actuator.kv),
        **({"terms": dict(actuator.terms)} if actuator.terms else {}),
        "control": None if actuator.control is None else as_floats(actuator.control),
        "force": None if actuator.force is None else as_floats(actuator.force),
        "home": as_float(actuator.home, TURN),
        "load": short(actuator.load),
        "home_load": short(actuator.home_load),
        **({"holds": _holds(actuator)} if actuator.holds else {}),
        "sag": short(actuator.sag),
        "estimated": list(actuator.estimated),
        **({"motor": actuator.motor} if actuator.motor else {}),
        **({"provenance": dict(actuator.sources)} if actuator.sources else {}),
    }


def _holds(actuator: Actuator) -> dict[str, float | None]:
    return {keyframe: as_float(force, FORCE) for keyframe, force in actuator.holds}


def actuation_records(actuation: Actuation) -> dict[str, Any]:
    """The tables of actuators, of added armatures and of compensated weight, as far as there are some."""
    tables: dict[str, list[Any]] = {
        "actuators": [_actuator(one) for one in actuation.actuators],
        "armatures": [
            {"dof": one.dof, "value": as_float(one.value), "reason": one.reason}
            for one in actuation.armatures
        ],
        "compensated": [{"link": link, "share": as_float(share)} for link, share in actuation.compensated],
        "compensating": list(actuation.compensating),
    }
    return {name: rows for name, rows in tables.items() if rows}


def sensing_records(sensing: Sensing) -> dict[str, Any]:
    """The tables of sensors, and of their places and cameras, as far as there are some."""
    tables = {
        "sensors": [sensor_record(one) for one in sensing.sensors],
        "sensor_sites": [_site(one) for one in sensing.sites],
        "cameras": [_camera(one) for one in sensing.cameras],
    }
    return {name: rows for name, rows in tables.items() if rows}


def _site(site: SensorSite) -> dict[str, Any]:
    zone = {"shape": site.shape or None, "size": as_floats(site.size) if site.shape else None}
    return {"name": site.name, "link": site.link, "pose": as_pose(site.link_from_site), **zone}


def _camera(camera: SensorCamera) -> dict[str, Any]:
    return {
        "name": camera.name,
        "link": camera.link,
        "pose": as_pose(camera.link_from_camera),
        "fovy": as_float(camera.fovy),
        "resolution": list(camera.resolution),
    }


def sensor_record(sensor: Sensor) -> dict[str, Any]:
    """`on` and `relative_to`: {kind, name}, null for nothing."""
    ends = (sensor.target, sensor.name_of_target), (sensor.relative_to, sensor.name_of_relative)
    on, of = ({"kind": kind, "name": name} if kind else None for kind, name in ends)
    numbers = {"noise": as_float(sensor.noise), "cutoff": as_float(sensor.cutoff)}
    zone = {"shape": sensor.shape, "size": as_floats(sensor.size)} if sensor.shape else {}
    return {"name": sensor.name, "type": sensor.type, "on": on, "relative_to": of, **numbers, **zone}
