"""Determines the content of ros2_control: interfaces of joints, sensors, and the hardware."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from linkwright.stages.export.ros2.description import Description
from linkwright.stages.export.ros2.names import legal_names
from linkwright.stages.formats.urdf.names import UrdfNames
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.poses import motion, turns_from_rotation
from linkwright.stages.robot.model.robot import Robot, Sensor
from linkwright.stages.robot.model.sensing import Sensing
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.text.names import common_stem, free_name

COMMANDS: Mapping[str, str] = {
    "position": "position",
    "pid": "position",
    "velocity": "velocity",
    "intvelocity": "velocity",
    "motor": "effort",
}
"""Type of an actuator → the interface that commands it."""

DEFAULT_COMMAND = "effort"
"""The interface that commands actuators of any other type."""

COMMAND_ORDER = ("position", "velocity", "effort")
"""Command interfaces that have controllers, in the order of the file."""

EFFORT_SENSORS = ("jointactuatorfrc", "actuatorfrc")
"""MuJoCo's sensors of the quantity that ros2_control calls effort."""

JOINT_SENSORS = (*EFFORT_SENSORS, "jointpos", "jointvel", "actuatorpos", "actuatorvel")
"""MuJoCo's sensors of quantities that are state interfaces of joints."""

IMU_SENSORS = ("gyro", "accelerometer", "framequat")
"""MuJoCo's sensors that an IMU combines."""

LOAD_SENSORS = ("force", "torque")
"""MuJoCo's sensors that a force-torque sensor combines."""

INTERFACES: Mapping[str, tuple[str, ...]] = {
    "imu": (
        *(f"orientation.{axis}" for axis in "xyzw"),
        *(f"angular_velocity.{axis}" for axis in "xyz"),
        *(f"linear_acceleration.{axis}" for axis in "xyz"),
    ),
    "force_torque": (*(f"force.{axis}" for axis in "xyz"), *(f"torque.{axis}" for axis in "xyz")),
}
"""Kind of a sensor → its state interfaces, as its broadcaster expects them."""

Parameters = tuple[tuple[str, str], ...]
"""(name, text) of each <param>."""

JOINT_KEY = ""
"""Key of a joint's own parameters, in the table of parameters by interface."""

_MIMIC_PARAMETERS = ("mimic", "multiplier")
"""Parameters that the package derives from the URDF's <mimic>."""


@dataclass(frozen=True, slots=True)
class ControlJoint:
    """A joint of ros2_control."""

    name: str
    """The name of the joint in the package."""

    commands: tuple[str, ...]
    """The interfaces that command it."""

    states: tuple[str, ...]
    """The interfaces that measure it."""

    home: float
    """The value [rad or m] of the joint at `home`."""

    follows: tuple[str, str] | None
    """(driver, multiplier as text in the URDF) of a joint that follows another; None for other joints."""

    parameters: Mapping[str, Parameters] = field(default_factory=dict)
    """Command interface → its parameters in the source; `JOINT_KEY` → those of the joint itself."""


@dataclass(frozen=True, slots=True)
class ControlSensor:
    """A sensor of ros2_control."""

    name: str

    kind: str
    """A key of `INTERFACES`."""

    frame: str
    """The link in whose frame the sensor measures."""


@dataclass(frozen=True, slots=True)
class Control:
    """The content of ros2_control: interfaces of joints, sensors, and the hardware."""

    joints: tuple[ControlJoint, ...]
    sensors: tuple[ControlSensor, ...]

    plugin: str = ""
    """The plugin of the source's hardware; "" without such hardware."""

    parameters: Parameters = ()
    """The parameters of the source's hardware."""

    effort_fallbacks: tuple[tuple[str, str], ...] = ()
    """(joint, type) of each actuator without an interface of its own, which is commanded by effort."""

    follower_joints: tuple[str, ...] = ()
    """The joints that follow others, and so are not commanded, although they have an actuator or, in the
    source, a command interface."""

    left_out: tuple[str, ...] = ()
    """The names of sensors without a counterpart in ros2_control."""

    def commanded(self, interface: str) -> list[str]:
        """Returns the joints that have a command interface of this name."""
        return [joint.name for joint in self.joints if interface in joint.commands]


@dataclass(frozen=True, slots=True, eq=False)
class Ros2Plan:
    """The description and the control of the package. `moveit`: whether MoveIt has a package beside it."""

    description: Description
    control: Control
    moveit: bool


def control_of(written: Written, description: Description) -> Control:
    """Returns the content of ros2_control: every moving joint of the URDF, with its interfaces."""
    controls = description.root.findall("ros2_control")
    home_values = _home_values(written.robot, written.urdf_names)
    source_parameters = _source_interfaces(controls)
    urdf_names = {name: urdf_name for urdf_name, name in description.names.joints.items()}
    actuator_types: dict[str, list[str]] = defaultdict(list)
    for actuator in written.actuation.actuators:
        actuator_types[actuator.dof].append(actuator.type)
    measured_dofs = _measured_dofs(written.actuation, written.sensing)
    joints, effort_fallbacks, follower_joints = [], [], []
    for node in description.moving:
        name = str(node.get("name"))
        urdf_name = urdf_names[name]
        types = actuator_types[urdf_name]
        parameters_of_joint = source_parameters.get(name, {})
        interfaces = {COMMANDS.get(type_, DEFAULT_COMMAND) for type_ in types}
        if not interfaces:
            # Without an actuator, the joint has the command interfaces of the source.
            interfaces = {*parameters_of_joint} - {JOINT_KEY}
        follows = _driver_of(node)
        if interfaces and follows:
            follower_joints.append(name)
        effort_fallbacks += [(name, type_) for type_ in types if type_ not in COMMANDS and not follows]
        commands = (
            () if follows else tuple(interface for interface in COMMAND_ORDER if interface in interfaces)
        )
        has_effort = "effort" in commands or urdf_name in measured_dofs
        states = ("position", "velocity", "effort") if has_effort else ("position", "velocity")
        joints.append(
            ControlJoint(
                name, commands, states, home_values.get(urdf_name, 0.0), follows, parameters_of_joint
            )
        )
    sensors, left_out = _sensors(written, description, [joint.name for joint in joints])
    plugin, parameters = _hardware(controls)
    return Control(
        tuple(joints),
        sensors,
        plugin,
        parameters,
        tuple(effort_fallbacks),
        tuple(follower_joints),
        tuple(left_out),
    )


def _home_values(robot: Robot, names: UrdfNames) -> dict[str, float]:
    """Returns the value [rad or m] of each moving joint of the URDF at `home`."""
    values: dict[str, float] = {}
    pose = home(robot)
    for dof in robot.dofs:
        value = pose[dof.name]
        if dof.kind == "ball":
            angles = turns_from_rotation(motion("ball", dof.axis, value)[:3, :3])
            values |= zip(names.turns[dof.name], angles, strict=True)
        elif not isinstance(value, tuple):
            values[dof.name] = value
    return values


def _source_interfaces(controls: Sequence[Element]) -> dict[str, dict[str, Parameters]]:
    """Returns, for each joint in the URDF's <ros2_control>, its command interfaces with their parameters, and
    its own parameters."""
    interfaces: dict[str, dict[str, Parameters]] = {}
    for joint in (child for control in controls for child in control.iterchildren("joint")):
        parameters_of_joint = interfaces.setdefault(str(joint.get("name")), {})
        parameters_of_joint[JOINT_KEY] = tuple(
            pair for pair in _parameters(joint) if pair[0] not in _MIMIC_PARAMETERS
        )
        parameters_of_joint |= {
            str(child.get("name")): _parameters(child) for child in joint.iterchildren("command_interface")
        }
    return interfaces


def _parameters(node: Element) -> Parameters:
    """Returns the parameters that an element of <ros2_control> has."""
    return tuple(
        (str(parameter.get("name")), (parameter.text or "").strip())
        for parameter in node.iterchildren("param")
    )


def _driver_of(joint: Element) -> tuple[str, str] | None:
    """Returns (driver, multiplier) of a joint that follows another; None for other joints."""
    mimic = joint.find("mimic")
    return None if mimic is None else (str(mimic.get("joint")), str(mimic.get("multiplier", "1")))


def _measured_dofs(actuation: Actuation, sensing: Sensing) -> set[str]:
    """Returns the dofs whose effort a sensor measures, at the dof or at its actuator."""
    dof_by_actuator = {actuator.name: actuator.dof for actuator in actuation.actuators}
    return {
        dof_by_actuator.get(sensor.name_of_target, "")
        if sensor.target == "actuator"
        else sensor.name_of_target
        for sensor in sensing.sensors
        if sensor.type in EFFORT_SENSORS
    }


def _hardware(controls: Sequence[Element]) -> tuple[str, Parameters]:
    """Returns the plugin of the first hardware in the URDF's <ros2_control> that names one, and its
    parameters; ("", ()) without such hardware. `controls`: the <ros2_control> elements."""
    for hardware in (child for control in controls for child in control.iterchildren("hardware")):
        plugin = (hardware.findtext("plugin") or "").strip()
        if plugin:
            return plugin, _parameters(hardware)
    return "", ()


def _sensors(
    written: Written, description: Description, joints: Sequence[str]
) -> tuple[tuple[ControlSensor, ...], list[str]]:
    """Returns the sensors, each for all of a kind on a frame, and the names of those without counterpart."""
    frames, sensing = dict(_frames(written, description)), written.sensing
    groups: dict[tuple[str, str, str], list[Sensor]] = defaultdict(list)
    left_out = [camera.name for camera in sensing.cameras]
    for sensor in sensing.sensors:
        kind = ""
        if sensor.type in IMU_SENSORS:
            kind = "imu"
        elif sensor.type in LOAD_SENSORS:
            kind = "force_torque"
        if (
            kind
            and sensor.target in ("site", "xbody")
            and sensor.name_of_target in frames
            and not sensor.relative_to
        ):
            groups[kind, sensor.target, sensor.name_of_target].append(sensor)
        elif sensor.type not in JOINT_SENSORS:
            left_out.append(sensor.name)
    names_and_places = []
    for (kind, _, place), measured in groups.items():
        types = {sensor.type for sensor in measured}
        if types == {"framequat"}:
            # TF already publishes the orientation of a frame.
            left_out += [sensor.name for sensor in measured]
        else:
            names_and_places.append(
                (common_stem([sensor.name for sensor in measured]) or f"{place}_{kind}", kind, place)
            )
    used_names = set(joints)
    names = legal_names([name for name, _, _ in names_and_places], "sensor")
    sensors = []
    for name, kind, place in names_and_places:
        unique_name = free_name(names[name], used_names)
        used_names.add(unique_name)
        sensors.append(ControlSensor(unique_name, kind, frames[place]))
    return tuple(sensors), left_out


def _frames(written: Written, description: Description) -> Iterator[tuple[str, str]]:
    """Yields (name of a site, frame or link, the link of the package with the same pose)."""
    package_links = description.names.links
    link_by_name = {link.name: link.name for link in written.as_urdf.robot.links}
    link_by_name |= {
        site.name: site.link
        for site in written.sensing.sites
        if site.link in link_by_name and np.array_equal(site.link_from_site, np.eye(4))
    }
    link_by_name |= written.urdf_names.frames
    # The user's own XML may have taken a link away.
    yield from ((name, package_links[link]) for name, link in link_by_name.items() if link in package_links)
