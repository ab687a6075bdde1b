"""Sensors of an SDF: on links those that are mounted, on joints those of their load."""

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.model.sensing import Sensing, Sensor, SensorCamera
from linkwright.stages.robot.text.names import free

KINDS: Mapping[str, str] = {
    "gyro": "imu",
    "accelerometer": "imu",
    "framequat": "imu",
    "magnetometer": "magnetometer",
    "force": "force_torque",
    "torque": "force_torque",
    "touch": "contact",
    "rangefinder": "gpu_lidar",
}
"""MuJoCo's element → SDF's type; those of one type on one place are one sensor."""

LONGEST = 100.0
"""How far [m] a rangefinder without `cutoff` sees: SDF demands an end."""

NEAREST = 1e-3
"""From where on [m] it sees."""

ASIDE = 1e-9
"""Beyond this [m] from the origin of its joint a sensor counts as elsewhere."""

_NOISY: Mapping[str, tuple[str, ...]] = {
    "gyro": ("angular_velocity",),
    "accelerometer": ("linear_acceleration",),
    "magnetometer": (),
    "force": ("force",),
    "torque": ("torque",),
}
"""MuJoCo's element → what SDF has the noise of its x, y and z in."""

_ALONG_Z = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""The rotation (3, 3) whose x axis, along which SDF's lidars look, is the z axis."""

_FROM_IMAGE = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""camera_from_sensor (3, 3): SDF's cameras look along x, with z up; ours along z, with y down."""


@dataclass(frozen=True, slots=True, eq=False)
class SdfSensor:
    """One sensor of the SDF: what it measures, and where (4, 4) on which link."""

    name: str
    type: str
    link: str
    link_from_sensor: Array
    measured: tuple[Sensor, ...]
    camera: SensorCamera | None = None

    @property
    def aside(self) -> bool:
        """Whether it measures a torque and is not at the origin of its joint, about which SDF has torques."""
        torque = any(one.type == "torque" for one in self.measured)
        return torque and math.hypot(*self.link_from_sensor[:3, 3]) > ASIDE

    @property
    def on_joint(self) -> bool:
        """Whether it belongs to the joint above its link."""
        return self.type == "force_torque"


@dataclass(frozen=True, slots=True)
class Sensors:
    """What is in the SDF, and the names of MuJoCo's sensors that are not."""

    mounted: tuple[SdfSensor, ...]
    left_out: tuple[str, ...]


def sensors_of(robot: Robot, sensing: Sensing, held: Sequence[str], solid: Sequence[str]) -> Sensors:
    """The sensors that SDF has. `held`: the links that a joint of the robot holds, whose load can be
    measured; `solid`: those with colliders, that something can press on."""
    places = _places(robot, sensing)
    groups: dict[tuple[str, str, str], list[Sensor]] = defaultdict(list)
    left_out = []
    for one in sensing.sensors:
        type_ = KINDS.get(one.type)
        place = places.get((one.target == "body", one.name_of_target)) if one.target else None
        possible = type_ is not None and place is not None and not one.relative_to
        if possible and type_ == "force_torque":
            possible = place is not None and place[0] in held
        if possible and type_ == "contact":
            possible = place is not None and place[0] in solid
        if possible and type_ is not None:
            groups[type_, one.target, one.name_of_target].append(one)
        else:
            left_out.append(one.name)
    mounted = []
    taken: set[str] = set()
    for (type_, target, name), measured in groups.items():
        if {one.type for one in measured} == {"framequat"}:
            # An orientation alone is that of a frame, which needs no imu.
            left_out += [one.name for one in measured]
            continue
        link, pose = places[target == "body", name]
        if type_ == "gpu_lidar":
            pose = pose @ from_parts(_ALONG_Z, np.zeros(3))
        own = free(_common([one.name for one in measured]) or f"{name}_{type_}", taken)
        taken.add(own)
        mounted.append(SdfSensor(own, type_, link, pose, tuple(measured)))
    for camera in sensing.cameras:
        own = free(camera.name, taken)
        taken.add(own)
        turned = camera.link_from_camera @ from_parts(_FROM_IMAGE, np.zeros(3))
        mounted.append(SdfSensor(own, "camera", camera.link, turned, (), camera))
    return Sensors(tuple(mounted), tuple(left_out))


def write_sensor(above: Element, one: SdfSensor, name: str, colliders: Sequence[str]) -> Element:
    """A sensor under its link or joint, without its pose. `colliders`: the names of its link's."""
    node = element(above, "sensor", name=name, type=one.type)
    element(node, "always_on").text = "true"
    if one.type in ("imu", "magnetometer", "force_torque"):
        inner = element(node, one.type)
        if one.type == "force_torque":
            element(inner, "frame").text = "sensor"
            # As MuJoCo: what the link exerts on the one above.
            element(inner, "measure_direction").text = "child_to_parent"
        for sensor in one.measured:
            if sensor.noise and sensor.type in _NOISY:
                _noise_of_axes(inner, _NOISY[sensor.type], sensor.noise)
    elif one.type == "contact":
        inner = element(node, "contact")
        for collider in colliders:
            element(inner, "collision").text = collider
    elif one.type == "gpu_lidar":
        _lidar(node, one.measured[0])
    elif one.camera is not None:
        _camera(node, one.camera)
    return node


def _places(robot: Robot, sensing: Sensing) -> dict[tuple[bool, str], tuple[str, Array]]:
    """(whether its centre of mass is meant, name) → link, with link_from_place (4, 4)."""
    found = {(True, link.name): (link.name, from_parts(np.eye(3), link.inertial.com)) for link in robot.links}
    found |= {(False, link.name): (link.name, np.eye(4)) for link in robot.links}
    found |= {(False, frame.name): (frame.link, frame.link_from_frame) for frame in robot.frames}
    return found | {(False, site.name): (site.link, site.link_from_site) for site in sensing.sites}


def _common(names: Sequence[str]) -> str:
    """The one name, or what several have before their last "_"; "" where that differs."""
    if len(names) == 1:
        return names[0]
    stems = {name.rpartition("_")[0] for name in names}
    return stems.pop() if len(stems) == 1 else ""


def _noise_of_axes(above: Element, path: Sequence[str], deviation: float) -> None:
    for tag in path:
        above = element(above, tag)
    for axis in "xyz":
        _noise(element(above, axis), deviation)


def _noise(above: Element, deviation: float) -> None:
    node = element(above, "noise", type="gaussian")
    element(node, "mean").text = "0"
    element(node, "stddev").text = number(deviation)


def _lidar(node: Element, sensor: Sensor) -> None:
    """One ray."""
    lidar = element(node, "lidar")
    across = element(element(lidar, "scan"), "horizontal")
    for tag, text in (("samples", "1"), ("resolution", "1"), ("min_angle", "0"), ("max_angle", "0")):
        element(across, tag).text = text
    ends = element(lidar, "range")
    element(ends, "min").text = number(NEAREST)
    element(ends, "max").text = number(sensor.cutoff or LONGEST)
    if sensor.noise:
        noise = element(lidar, "noise")
        for tag, text in (("type", "gaussian"), ("mean", "0"), ("stddev", number(sensor.noise))):
            element(noise, tag).text = text


def _camera(node: Element, camera: SensorCamera) -> None:
    inner = element(node, "camera")
    width, height = camera.resolution
    half = math.tan(math.radians(camera.fovy) / 2) * width / height
    element(inner, "horizontal_fov").text = number(2 * math.atan(half))
    image = element(inner, "image")
    element(image, "width").text = str(width)
    element(image, "height").text = str(height)
    clip = element(inner, "clip")
    element(clip, "near").text = "0.01"
    element(clip, "far").text = "100"
