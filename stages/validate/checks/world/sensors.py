"""Each sensor measures what it shall, where it shall, and each camera is where it shall be."""

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index, index_of, name_of
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Sensor
from linkwright.stages.robot.model.sensing import SensorCamera
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, few, named, worst_first
from linkwright.stages.validate.model.coordinates import SAME, body_from_link, placed_by_site
from linkwright.stages.validate.model.poses import placed

KINDS: Mapping[str, int] = {
    "joint": mujoco.mjtObj.mjOBJ_JOINT,
    "actuator": mujoco.mjtObj.mjOBJ_ACTUATOR,
    "site": mujoco.mjtObj.mjOBJ_SITE,
    "body": mujoco.mjtObj.mjOBJ_BODY,
    "xbody": mujoco.mjtObj.mjOBJ_XBODY,
    "camera": mujoco.mjtObj.mjOBJ_CAMERA,
}
"""What a sensor may be on, as MuJoCo numbers it."""

NAMES: Mapping[str, str] = {"jointactuatorfrc": "JOINTACTFRC"}
"""Elements whose names in MuJoCo's code are others."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """A URDF has no sensors."""
    sensing = compiled.written.sensing
    if compiled.urdf or not (sensing.sensors or sensing.cameras):
        return
    found = [finding for one in sensing.sensors for finding in _differences(compiled.model, one)]
    missing = [one.name for one in sensing.cameras if _index(compiled.model, "camera", one.name) < 0]
    found += [Finding(named("camera", name), "name", "there is no camera of this name") for name in missing]
    found += [finding for one in sensing.cameras for finding in _lens(compiled, one)]
    found += [] if found else _order(compiled)
    wrong = dict.fromkeys(finding.element for finding in found)
    detail = f"{len(sensing.sensors)} sensors on what they measure"
    if wrong:
        detail = f"differ: {', '.join(wrong)}"
    yield compiled.result("sensors", not wrong, detail, float(len(wrong)), 0.0, few(found))
    mounted = [("site", one.name, one.link, one.link_from_site) for one in sensing.sites]
    mounted += [("camera", one.name, one.link, one.link_from_camera) for one in sensing.cameras]
    if mounted and not wrong:
        off = [(_off(compiled, *one), _misplaced(compiled, *one)) for one in mounted]
        worst = max(value for value, _ in off)
        places = worst_first(one for one in off if not one[0] <= SAME)
        detail = f"{len(mounted)} places of sensors and cameras"
        yield compiled.within("places of sensors", worst, SAME, detail, places)


def _lens(compiled: CompiledModel, one: SensorCamera) -> Iterator[Finding]:
    """What a camera sees, where it is there: the angle [deg] and the pixels."""
    model, index = compiled.model, _index(compiled.model, "camera", one.name)
    for attribute, numbers, wanted in (
        ("fovy", "cam_fovy", one.fovy),
        ("resolution", "cam_resolution", one.resolution),
    ):
        found = getattr(model, numbers)[index] if index >= 0 else wanted
        if not np.allclose(found, wanted, rtol=SAME) and not compiled.sets(attribute):
            yield differs(named("camera", one.name), attribute, found, wanted)


def _order(compiled: CompiledModel) -> Iterator[Finding]:
    """The robot's sensors are in `sensordata` in their order."""
    types = {one.name: one.type for one in compiled.written.sensing.sensors}
    wanted = list(types)
    found = [compiled.model.sensor(index).name for index in range(compiled.model.nsensor)]
    for place, (one, other) in enumerate(
        zip(wanted, (name for name in found if name in wanted), strict=True)
    ):
        if one != other:
            message = f"is where {one} must be: sensordata has the sensors in this order ({place} before it)"
            yield Finding(named(types[other], other), "order", message)
            return


def _misplaced(compiled: CompiledModel, kind: str, name: str, link: str, _: Any) -> Finding:
    message = f"is not where it must be on {link}, or turned otherwise, or missing"
    return Finding(named(kind, name), "pos, quat", message)


def _index(model: Any, kind: str, name: str) -> int:
    # An xbody has the name of its body.
    return index_of(model, KINDS["body" if kind == "xbody" else kind], name)


def _differences(model: Any, one: Sensor) -> Iterator[Finding]:
    element = named(one.type, one.name)
    index = index_of(model, mujoco.mjtObj.mjOBJ_SENSOR, one.name)
    if index < 0:
        yield Finding(element, "name", "there is no sensor of this name")
        return
    kind = mujoco.mjtSensor(int(model.sensor_type[index])).name.removeprefix("mjSENS_")
    if kind != NAMES.get(one.type, one.type.upper()):
        yield Finding(element, "type", f"is a {kind.lower()}")
        return
    if not one.relative_to and model.sensor_refid[index] >= 0:
        yield Finding(element, "refname", "is relative to something, expected to the world")
    ends = (
        ("", one.target, one.name_of_target, model.sensor_objtype[index], model.sensor_objid[index]),
        (
            "ref",
            one.relative_to,
            one.name_of_relative,
            model.sensor_reftype[index],
            model.sensor_refid[index],
        ),
    )
    for role, target, name, found, number in ends:
        if target and not (int(found) == KINDS[target] and int(number) == _index(model, target, name)):
            other = name_of(model, int(found), int(number)) if number >= 0 else None
            attribute = "refname" if role else ATTRIBUTES.get(target, target)
            yield differs(element, attribute, other or "none", name)
    for attribute, value, wanted in (
        ("noise", float(model.sensor_noise[index]), one.noise),
        ("cutoff", float(model.sensor_cutoff[index]), one.cutoff),
    ):
        if not abs(value - wanted) <= SAME * max(1.0, wanted):
            yield differs(element, attribute, value, wanted)


ATTRIBUTES: Mapping[str, str] = {"body": "objname", "xbody": "objname", "camera": "camera"}
"""What a sensor's attribute is called that names what it is on, where that is not what it is."""


def _off(compiled: CompiledModel, kind: str, name: str, link: str, link_from_it: Any) -> float:
    """How far [m, rad] a place is from where it shall be on its link."""
    model = compiled.model
    index = _index(model, kind, name)
    if index < 0:
        return np.inf
    holder, holder_from_link = compiled.held.get(link, (link, np.eye(4)))
    if holder == "world":
        # The link is where the scene puts it, and the body is the world.
        holder_from_link = placed_by_site(model, holder) @ holder_from_link
    pose = body_from_link(compiled.robot, holder) @ holder_from_link @ link_from_it
    if kind == "camera":
        pose = pose @ np.diag([1.0, -1.0, -1.0, 1.0])
    quat, position, on = (
        getattr(model, f"{_SHORT[kind]}_{what}")[index] for what in ("quat", "pos", "bodyid")
    )
    found = placed(quat, position)
    return float(np.abs(found - pose).max()) if on == body_index(model, holder) else np.inf


_SHORT = {"site": "site", "camera": "cam"}
