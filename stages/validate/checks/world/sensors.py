"""Checks that each sensor measures its target at its place, and that each camera is at its place."""

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index, index_of, name_of
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Sensor
from linkwright.stages.robot.model.sensing import SensorCamera
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, few, largest_error, named, worst_first
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE, body_from_link, placed_by_site
from linkwright.stages.validate.model.poses import placed

OBJECT_TYPES: Mapping[str, int] = {
    "joint": mujoco.mjtObj.mjOBJ_JOINT,
    "actuator": mujoco.mjtObj.mjOBJ_ACTUATOR,
    "site": mujoco.mjtObj.mjOBJ_SITE,
    "body": mujoco.mjtObj.mjOBJ_BODY,
    "xbody": mujoco.mjtObj.mjOBJ_XBODY,
    "camera": mujoco.mjtObj.mjOBJ_CAMERA,
}
"""Kind of thing that a sensor may be on → MuJoCo's number."""

MUJOCO_NAMES: Mapping[str, str] = {"jointactuatorfrc": "JOINTACTFRC"}
"""Element → its name in MuJoCo's code, if that differs."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks robots with sensors or cameras. A URDF has no sensors."""
    sensing = compiled.written.sensing
    if compiled.urdf or not (sensing.sensors or sensing.cameras):
        return
    findings = [finding for sensor in sensing.sensors for finding in _differences(compiled.model, sensor)]
    missing = [camera.name for camera in sensing.cameras if _index(compiled.model, "camera", camera.name) < 0]
    findings += [
        Finding(named("camera", name), "name", "there is no camera of this name") for name in missing
    ]
    findings += [finding for camera in sensing.cameras for finding in _lens_differences(compiled, camera)]
    findings += [] if findings else _order_differences(compiled)
    wrong = dict.fromkeys(finding.element for finding in findings)
    detail = f"{len(sensing.sensors)} sensors on what they measure"
    if wrong:
        detail = f"differ: {', '.join(wrong)}"
    yield compiled.result("sensors", not wrong, detail, float(len(wrong)), 0.0, few(findings))
    mounted = [("site", site.name, site.link, site.link_from_site) for site in sensing.sites]
    mounted += [("camera", camera.name, camera.link, camera.link_from_camera) for camera in sensing.cameras]
    if mounted and not wrong:
        differences = [
            (_pose_difference(compiled, *mount), _misplaced_finding(compiled, *mount)) for mount in mounted
        ]
        worst = largest_error(value for value, _ in differences)
        places = worst_first(row for row in differences if not row[0] <= ENGINE_TOLERANCE)
        detail = f"{len(mounted)} places of sensors and cameras"
        yield compiled.within("places of sensors", worst, ENGINE_TOLERANCE, detail, places)


def _lens_differences(compiled: CompiledModel, camera: SensorCamera) -> Iterator[Finding]:
    """Compares the field of view [deg] and the pixels of a camera, if the model has it."""
    model, index = compiled.model, _index(compiled.model, "camera", camera.name)
    for attribute, numbers, expected in (
        ("fovy", "cam_fovy", camera.fovy),
        ("resolution", "cam_resolution", camera.resolution),
    ):
        value = getattr(model, numbers)[index] if index >= 0 else expected
        if not np.allclose(value, expected, rtol=ENGINE_TOLERANCE) and not compiled.sets(attribute):
            yield differs(named("camera", camera.name), attribute, value, expected)


def _order_differences(compiled: CompiledModel) -> Iterator[Finding]:
    """Yields a finding if the robot's sensors have another order in `sensordata`."""
    types = {sensor.name: sensor.type for sensor in compiled.written.sensing.sensors}
    expected = list(types)
    names = [compiled.model.sensor(index).name for index in range(compiled.model.nsensor)]
    for place, (name, other) in enumerate(
        zip(expected, (title for title in names if title in expected), strict=True)
    ):
        if name != other:
            message = f"is sensor {place + 1} in sensordata, where {name} must be"
            yield Finding(named(types[other], other), "order", message)
            return


def _misplaced_finding(compiled: CompiledModel, kind: str, name: str, link: str, _: Any) -> Finding:
    message = f"is not where it must be on {link}, or turned otherwise, or missing"
    return Finding(named(kind, name), "pos, quat", message)


def _index(model: Any, kind: str, name: str) -> int:
    """Returns the index of a thing in the model; -1 if it is missing. `kind`: a key of `OBJECT_TYPES`."""
    # An xbody has the name of its body.
    return index_of(model, OBJECT_TYPES["body" if kind == "xbody" else kind], name)


def _differences(model: Any, sensor: Sensor) -> Iterator[Finding]:
    element = named(sensor.type, sensor.name)
    index = index_of(model, mujoco.mjtObj.mjOBJ_SENSOR, sensor.name)
    if index < 0:
        yield Finding(element, "name", "there is no sensor of this name")
        return
    kind = mujoco.mjtSensor(int(model.sensor_type[index])).name.removeprefix("mjSENS_")
    if kind != MUJOCO_NAMES.get(sensor.type, sensor.type.upper()):
        yield Finding(element, "type", f"is a {kind.lower()}")
        return
    if not sensor.relative_to and model.sensor_refid[index] >= 0:
        yield Finding(element, "refname", "is relative to another frame, expected relative to the world")
    ends = (
        ("", sensor.target, sensor.name_of_target, model.sensor_objtype[index], model.sensor_objid[index]),
        (
            "ref",
            sensor.relative_to,
            sensor.name_of_relative,
            model.sensor_reftype[index],
            model.sensor_refid[index],
        ),
    )
    for role, target, name, kind_of_end, number in ends:
        if target and not (
            int(kind_of_end) == OBJECT_TYPES[target] and int(number) == _index(model, target, name)
        ):
            other = name_of(model, int(kind_of_end), int(number)) if number >= 0 else None
            attribute = "refname" if role else TARGET_ATTRIBUTES.get(target, target)
            yield differs(element, attribute, other or "none", name)
    for attribute, value, expected in (
        ("noise", float(model.sensor_noise[index]), sensor.noise),
        ("cutoff", float(model.sensor_cutoff[index]), sensor.cutoff),
    ):
        if not abs(value - expected) <= ENGINE_TOLERANCE * max(1.0, expected):
            yield differs(element, attribute, value, expected)


TARGET_ATTRIBUTES: Mapping[str, str] = {"body": "objname", "xbody": "objname", "camera": "camera"}
"""Kind of target → attribute that names it, if that is not called like the kind."""


def _pose_difference(compiled: CompiledModel, kind: str, name: str, link: str, link_from_mount: Any) -> float:
    """Returns the largest difference of an entry between the pose [m] of a site or camera and its place on
    its link; infinite if it is missing, or on another body."""
    model = compiled.model
    index = _index(model, kind, name)
    if index < 0:
        return np.inf
    holder, holder_from_link = compiled.held.get(link, (link, np.eye(4)))
    if holder == "world":
        # The body is the world, and the scene places the link on it.
        holder_from_link = placed_by_site(model, holder) @ holder_from_link
    pose = body_from_link(compiled.robot, holder) @ holder_from_link @ link_from_mount
    if kind == "camera":
        pose = pose @ np.diag([1.0, -1.0, -1.0, 1.0])
    quat, position, on = (
        getattr(model, f"{_FIELD_PREFIX[kind]}_{key}")[index] for key in ("quat", "pos", "bodyid")
    )
    actual = placed(quat, position)
    return float(np.abs(actual - pose).max()) if on == body_index(model, holder) else np.inf


_FIELD_PREFIX = {"site": "site", "camera": "cam"}
