"""Writes the sensors of an SDF: force and torque sensors on joints, all others on links."""

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
from linkwright.stages.robot.text.names import common_stem, free_name

SDF_TYPES: Mapping[str, str] = {
    "gyro": "imu",
    "accelerometer": "imu",
    "framequat": "imu",
    "magnetometer": "magnetometer",
    "force": "force_torque",
    "torque": "force_torque",
    "touch": "contact",
    "rangefinder": "gpu_lidar",
}
"""MuJoCo's element → SDF's type. Elements of the same type and place become a single sensor."""

DEFAULT_RANGE = 100.0
"""Range [m] of a rangefinder without `cutoff`: SDF requires an upper end."""

MIN_RANGE = 1e-3
"""Smallest distance [m] that a rangefinder measures."""

NEAR_CLIP, FAR_CLIP = 0.01, 100.0
"""The distances [m] between which a camera sees."""

ORIGIN_TOLERANCE = 1e-9
"""Distance [m] from the origin of its joint beyond which a sensor counts as elsewhere."""

_NOISE_PATHS: Mapping[str, tuple[str, ...]] = {
    "gyro": ("angular_velocity",),
    "accelerometer": ("linear_acceleration",),
    "magnetometer": (),
    "force": ("force",),
    "torque": ("torque",),
}
"""MuJoCo's element → the path of the SDF element that has the noise of its x, y and z."""

_ALONG_Z = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""The rotation (3, 3) whose x axis, along which SDF's lidars look, is the z axis."""

_FROM_IMAGE = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""camera_from_sensor (3, 3): SDF's cameras look along x, with z up; ours along z, with y down."""

_Places = Mapping[tuple[bool, str], tuple[str, Array]]


@dataclass(frozen=True, slots=True, eq=False)
class SdfSensor:
    """A sensor of the SDF."""

    name: str
    type: str
    link: str

    link_from_sensor: Array
    """Its pose (4, 4) on the link."""

    measured: tuple[Sensor, ...]
    """The robot's sensors that it combines."""

    camera: SensorCamera | None = None
    """The robot's camera, for a sensor that is a camera."""

    @property
    def is_off_joint_origin(self) -> bool:
        """Tells whether the sensor measures a torque away from its joint's origin, about which SDF has
        torques."""
        torque = any(sensor.type == "torque" for sensor in self.measured)
        return torque and math.hypot(*self.link_from_sensor[:3, 3]) > ORIGIN_TOLERANCE

    @property
    def is_on_joint(self) -> bool:
        """Tells whether the sensor belongs to the joint above its link."""
        return self.type == "force_torque"


@dataclass(frozen=True, slots=True)
class Sensors:
    """The sensors of an SDF."""

    mounted: tuple[SdfSensor, ...]

    left_out: tuple[str, ...]
    """The names of the robot's sensors that the SDF leaves out."""


def sensors_of(
    robot: Robot, sensing: Sensing, jointed_links: Sequence[str], links_with_colliders: Sequence[str]
) -> Sensors:
    """Returns the sensors that SDF can express. `jointed_links`: the links that a joint of the robot holds,
    whose load can be measured; `links_with_colliders`: those on which something can press."""
    places = _places(robot, sensing)
    groups: dict[tuple[str, str, str], list[Sensor]] = defaultdict(list)
    left_out = []
    for sensor in sensing.sensors:
        type_ = _sdf_type(sensor, places, jointed_links, links_with_colliders)
        if type_ is None:
            left_out.append(sensor.name)
        else:
            groups[type_, sensor.target, sensor.name_of_target].append(sensor)
    mounted = []
    used_names: set[str] = set()
    for (type_, target, name), measured in groups.items():
        if {sensor.type for sensor in measured} == {"framequat"}:
            # An orientation alone can be read from a frame, without an imu.
            left_out += [sensor.name for sensor in measured]
            continue
        link, pose = places[target == "body", name]
        if type_ == "gpu_lidar":
            pose = pose @ from_parts(_ALONG_Z, np.zeros(3))
        unique_name = free_name(
            common_stem([sensor.name for sensor in measured]) or f"{name}_{type_}", used_names
        )
        used_names.add(unique_name)
        mounted.append(SdfSensor(unique_name, type_, link, pose, tuple(measured)))
    for camera in sensing.cameras:
        unique_name = free_name(camera.name, used_names)
        used_names.add(unique_name)
        link_from_sensor = camera.link_from_camera @ from_parts(_FROM_IMAGE, np.zeros(3))
        mounted.append(SdfSensor(unique_name, "camera", camera.link, link_from_sensor, (), camera))
    return Sensors(tuple(mounted), tuple(left_out))


def write_sensor(parent: Element, mounted: SdfSensor, name: str, colliders: Sequence[str]) -> Element:
    """Writes a sensor under its link or joint, without its pose. `name`: its name among its siblings, which
    may differ from `mounted.name`; `colliders`: the names of its link's colliders."""
    node = element(parent, "sensor", name=name, type=mounted.type)
    element(node, "always_on").text = "true"
    if mounted.type in ("imu", "magnetometer", "force_torque"):
        inner = element(node, mounted.type)
        if mounted.type == "force_torque":
            element(inner, "frame").text = "sensor"
            # As in MuJoCo: the force that the link exerts on the link above.
            element(inner, "measure_direction").text = "child_to_parent"
        for sensor in mounted.measured:
            if sensor.noise and sensor.type in _NOISE_PATHS:
                _noise_of_axes(inner, _NOISE_PATHS[sensor.type], sensor.noise)
    elif mounted.type == "contact":
        inner = element(node, "contact")
        for collider in colliders:
            element(inner, "collision").text = collider
    elif mounted.type == "gpu_lidar":
        _lidar(node, mounted.measured[0])
    elif mounted.camera is not None:
        _camera(node, mounted.camera)
    return node


def _sdf_type(
    sensor: Sensor, places: _Places, jointed_links: Sequence[str], links_with_colliders: Sequence[str]
) -> str | None:
    """Returns SDF's type of a sensor; None if SDF cannot express the sensor."""
    type_ = SDF_TYPES.get(sensor.type)
    place = places.get((sensor.target == "body", sensor.name_of_target)) if sensor.target else None
    if type_ is None or place is None or sensor.relative_to:
        return None
    link, _ = place
    if type_ == "force_torque" and link not in jointed_links:
        return None
    if type_ == "contact" and link not in links_with_colliders:
        return None
    return type_


def _places(robot: Robot, sensing: Sensing) -> _Places:
    """Maps (whether the target is a centre of mass, name of the target) to its link and link_from_target (4,
    4)."""
    places = {
        (True, link.name): (link.name, from_parts(np.eye(3), link.inertial.com)) for link in robot.links
    }
    places |= {(False, link.name): (link.name, np.eye(4)) for link in robot.links}
    places |= {(False, frame.name): (frame.link, frame.link_from_frame) for frame in robot.frames}
    return places | {(False, site.name): (site.link, site.link_from_site) for site in sensing.sites}


def _noise_of_axes(parent: Element, path: Sequence[str], deviation: float) -> None:
    for tag in path:
        parent = element(parent, tag)
    for axis in "xyz":
        _noise(element(parent, axis), deviation)


def _noise(parent: Element, deviation: float) -> None:
    node = element(parent, "noise", type="gaussian")
    element(node, "mean").text = "0"
    element(node, "stddev").text = number(deviation)


def _lidar(node: Element, sensor: Sensor) -> None:
    """Writes a lidar with a single ray."""
    lidar = element(node, "lidar")
    horizontal = element(element(lidar, "scan"), "horizontal")
    for tag, text in (("samples", "1"), ("resolution", "1"), ("min_angle", "0"), ("max_angle", "0")):
        element(horizontal, tag).text = text
    range_ = element(lidar, "range")
    element(range_, "min").text = number(MIN_RANGE)
    element(range_, "max").text = number(sensor.cutoff or DEFAULT_RANGE)
    if sensor.noise:
        # The type of a lidar's noise is an element, not an attribute.
        noise = element(lidar, "noise")
        for tag, text in (("type", "gaussian"), ("mean", "0"), ("stddev", number(sensor.noise))):
            element(noise, tag).text = text


def _camera(node: Element, camera: SensorCamera) -> None:
    inner = element(node, "camera")
    width, height = camera.resolution
    # SDF has the horizontal angle of view, our cameras the vertical one.
    half_width = math.tan(math.radians(camera.fovy) / 2) * width / height
    element(inner, "horizontal_fov").text = number(2 * math.atan(half_width))
    image = element(inner, "image")
    element(image, "width").text = str(width)
    element(image, "height").text = str(height)
    clip = element(inner, "clip")
    element(clip, "near").text = number(NEAR_CLIP)
    element(clip, "far").text = number(FAR_CLIP)
