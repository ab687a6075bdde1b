"""Each sensor measures what it shall, where it shall, and each camera is where it shall be."""

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from stages.robot.check import Check
from stages.robot.model import Sensor
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import SAME, body_index

CODE = "C-SENSOR"

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
    sensing = compiled.sensing
    if compiled.urdf or not (sensing.sensors or sensing.cameras):
        return
    wrong = [one.name for one in sensing.sensors if not _fits(compiled.model, one)]
    wrong += [one.name for one in sensing.cameras if _index(compiled.model, "camera", one.name) < 0]
    detail = (
        f"differ: {', '.join(wrong)}" if wrong else f"{len(sensing.sensors)} sensors on what they measure"
    )
    yield compiled.result("sensors", not wrong, detail, float(len(wrong)), 0.0)
    mounted = [("site", one.name, one.link, one.link_from_site) for one in sensing.sites]
    mounted += [("camera", one.name, one.link, one.link_from_camera) for one in sensing.cameras]
    if mounted and not wrong:
        off = max(_off(compiled, *one) for one in mounted)
        yield compiled.within("places of sensors", off, SAME, f"{len(mounted)} places of sensors and cameras")


def _index(model: Any, kind: str, name: str) -> int:
    # An xbody has the name of its body.
    return int(mujoco.mj_name2id(model, KINDS["body" if kind == "xbody" else kind], name))


def _fits(model: Any, one: Sensor) -> bool:
    index = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, one.name))
    if index < 0:
        return False
    kind = mujoco.mjtSensor(int(model.sensor_type[index])).name.removeprefix("mjSENS_")
    if kind != NAMES.get(one.type, one.type.upper()):
        return False
    if not one.relative_to and model.sensor_refid[index] >= 0:
        return False
    ends = (
        (one.target, one.name_of_target, model.sensor_objtype[index], model.sensor_objid[index]),
        (one.relative_to, one.name_of_relative, model.sensor_reftype[index], model.sensor_refid[index]),
    )
    return all(
        not target or (int(found) == KINDS[target] and int(number) == _index(model, target, name))
        for target, name, found, number in ends
    )


def _off(compiled: CompiledModel, kind: str, name: str, link: str, link_from_it: Any) -> float:
    """How far [m, rad] a place is from where it shall be on its link."""
    model = compiled.model
    index = _index(model, kind, name)
    if index < 0:
        return np.inf
    holder, holder_from_link = compiled.held.get(link, (link, np.eye(4)))
    if holder == "world":
        # The link is where the scene puts it, and the body is the world.
        site = _index(model, "site", holder)
        holder_from_link = _pose(model.site_pos[site], model.site_quat[site]) @ holder_from_link
    pose = holder_from_link @ link_from_it
    if kind == "camera":
        pose = pose @ np.diag([1.0, -1.0, -1.0, 1.0])
    found = _pose(
        *(getattr(model, f"{short}_{what}")[index] for what in ("pos", "quat") for short in (_SHORT[kind],))
    )
    on = getattr(model, f"{_SHORT[kind]}_bodyid")[index]
    return float(np.abs(found - pose).max()) if on == body_index(model, holder) else np.inf


_SHORT = {"site": "site", "camera": "cam"}


def _pose(position: Any, quaternion: Any) -> Any:
    out, turned = np.eye(4), np.zeros(9)
    mujoco.mju_quat2Mat(turned, quaternion)
    out[:3, :3], out[:3, 3] = turned.reshape(3, 3), position
    return out
