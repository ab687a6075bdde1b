"""What ros2_control commands and measures: interfaces of joints, sensors, and the hardware."""

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
from linkwright.stages.robot.text.names import free

COMMANDS: Mapping[str, str] = {
    "position": "position",
    "pid": "position",
    "velocity": "velocity",
    "intvelocity": "velocity",
    "motor": "effort",
}
"""Type of an actuator → what commands it; others are commanded by effort."""

OTHERS = "effort"

ORDER = ("position", "velocity", "effort")
"""The interfaces that controllers have."""

FORCES = ("jointactuatorfrc", "actuatorfrc")
"""MuJoCo's sensors of what ros2_control calls effort."""

OF_JOINTS = (*FORCES, "jointpos", "jointvel", "actuatorpos", "actuatorvel")
"""Those that are state interfaces of joints."""

IMU = ("gyro", "accelerometer", "framequat")
LOAD = ("force", "torque")

INTERFACES: Mapping[str, tuple[str, ...]] = {
    "imu": (
        *(f"orientation.{one}" for one in "xyzw"),
        *(f"angular_velocity.{one}" for one in "xyz"),
        *(f"linear_acceleration.{one}" for one in "xyz"),
    ),
    "force_torque": (*(f"force.{one}" for one in "xyz"), *(f"torque.{one}" for one in "xyz")),
}
"""Kind of a sensor → its state interfaces, those that its broadcaster asks for."""


Parameters = tuple[tuple[str, str], ...]
"""(name, text) of each <param>."""

JOINT = ""
"""The place of a joint's own parameters among those of its interfaces."""

_FOLLOWING = ("mimic", "multiplier")
"""Parameters that the package makes of the URDF's <mimic>."""


@dataclass(frozen=True, slots=True)
class ControlJoint:
    """A joint: the interfaces that command it and that are measured, its value [rad or m] at `home`, and
    (driver, multiplier as the URDF has it) where it follows another. `parameters`: of the source's
    <ros2_control>, by command interface; those of the joint itself are under ""."""

    name: str
    commands: tuple[str, ...]
    states: tuple[str, ...]
    home: float
    follows: tuple[str, str] | None
    parameters: Mapping[str, Parameters] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ControlSensor:
    """A sensor: `kind` is a key of `INTERFACES`, `frame` its link."""

    name: str
    kind: str
    frame: str


@dataclass(frozen=True, slots=True)
class Control:
    """What is commanded and measured. `plugin` and `parameters`: of the source's hardware, "" without.
    `by_effort`: (joint, type) of actuators that no interface is made for; `held_back`: joints that follow
    others and so cannot be commanded; `left_out`: the names of sensors without a counterpart."""

    joints: tuple[ControlJoint, ...]
    sensors: tuple[ControlSensor, ...]
    plugin: str = ""
    parameters: Parameters = ()
    by_effort: tuple[tuple[str, str], ...] = ()
    held_back: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()

    def commanded(self, interface: str) -> list[str]:
        """The joints that have a command interface of this name."""
        return [joint.name for joint in self.joints if interface in joint.commands]


@dataclass(frozen=True, slots=True, eq=False)
class Ros2Plan:
    """What the package describes and commands. `moveit`: whether MoveIt has a package beside it."""

    description: Description
    control: Control
    moveit: bool


def control_of(written: Written, description: Description) -> Control:
    """How ros2_control has the robot: every joint of the URDF that moves, and what drives it."""
    own = description.root.findall("ros2_control")
    values = _values(written.robot, written.urdf_names)
    given = _given(own)
    former = {name: before for before, name in description.names.joints.items()}
    driven: dict[str, list[str]] = defaultdict(list)
    for one in written.actuation.actuators:
        driven[one.dof].append(one.type)
    measured = _measured(written.actuation, written.sensing)
    joints, by_effort, held_back = [], [], []
    for node in description.moving:
        name = str(node.get("name"))
        before = former[name]
        types = driven[before]
        source = given.get(name, {})
        wanted = {COMMANDS.get(one, OTHERS) for one in types} or {*source} - {JOINT}
        follows = _follows(node)
        if wanted and follows:
            held_back.append(name)
        by_effort += [(name, one) for one in types if one not in COMMANDS and not follows]
        commands = () if follows else tuple(one for one in ORDER if one in wanted)
        effort = "effort" in commands or before in measured
        states = ("position", "velocity", "effort") if effort else ("position", "velocity")
        joints.append(ControlJoint(name, commands, states, values.get(before, 0.0), follows, source))
    sensors, left_out = _sensors(written, description, [one.name for one in joints])
    plugin, parameters = _hardware(own)
    return Control(
        tuple(joints), sensors, plugin, parameters, tuple(by_effort), tuple(held_back), tuple(left_out)
    )


def _values(robot: Robot, names: UrdfNames) -> dict[str, float]:
    """The value of each joint of the URDF at `home`."""
    found: dict[str, float] = {}
    at = home(robot)
    for dof in robot.dofs:
        value = at[dof.name]
        if dof.kind == "ball":
            turned = turns_from_rotation(motion("ball", dof.axis, value)[:3, :3])
            found |= zip(names.turns[dof.name], turned, strict=True)
        elif not isinstance(value, tuple):
            found[dof.name] = value
    return found


def _given(controls: Sequence[Element]) -> dict[str, dict[str, Parameters]]:
    """Joint → its command interfaces with their parameters, and its own, in the URDF's <ros2_control>s."""
    found: dict[str, dict[str, Parameters]] = {}
    for joint in (one for control in controls for one in control.iterchildren("joint")):
        own = found.setdefault(str(joint.get("name")), {})
        own[JOINT] = tuple(pair for pair in _parameters(joint) if pair[0] not in _FOLLOWING)
        own |= {str(one.get("name")): _parameters(one) for one in joint.iterchildren("command_interface")}
    return found


def _parameters(node: Element) -> Parameters:
    return tuple((str(one.get("name")), (one.text or "").strip()) for one in node.iterchildren("param"))


def _follows(joint: Element) -> tuple[str, str] | None:
    mimic = joint.find("mimic")
    return None if mimic is None else (str(mimic.get("joint")), str(mimic.get("multiplier", "1")))


def _measured(actuation: Actuation, sensing: Sensing) -> set[str]:
    """The dofs whose effort a sensor measures."""
    dofs = {one.name: one.dof for one in actuation.actuators}
    return {
        dofs.get(one.name_of_target, "") if one.target == "actuator" else one.name_of_target
        for one in sensing.sensors
        if one.type in FORCES
    }


def _hardware(controls: Sequence[Element]) -> tuple[str, Parameters]:
    """The plugin and the parameters of the first hardware that the URDF itself names."""
    for hardware in (one for control in controls for one in control.iterchildren("hardware")):
        plugin = (hardware.findtext("plugin") or "").strip()
        if plugin:
            return plugin, _parameters(hardware)
    return "", ()


def _sensors(
    written: Written, description: Description, joints: Sequence[str]
) -> tuple[tuple[ControlSensor, ...], list[str]]:
    """The sensors that have a broadcaster, and the names of those that have none."""
    frames, sensing = dict(_frames(written, description)), written.sensing
    groups: dict[tuple[str, str, str], list[Sensor]] = defaultdict(list)
    left_out = [camera.name for camera in sensing.cameras]
    for one in sensing.sensors:
        kind = "imu" if one.type in IMU else "force_torque" if one.type in LOAD else ""
        if kind and one.target in ("site", "xbody") and one.name_of_target in frames and not one.relative_to:
            groups[kind, one.target, one.name_of_target].append(one)
        elif one.type not in OF_JOINTS:
            left_out.append(one.name)
    made = []
    for (kind, _, place), measured in groups.items():
        types = {one.type for one in measured}
        if types == {"framequat"}:
            # TF has the orientation of a frame.
            left_out += [one.name for one in measured]
        else:
            made.append((stem_of_names([one.name for one in measured]) or f"{place}_{kind}", kind, place))
    taken = set(joints)
    names = legal_names([name for name, _, _ in made], "sensor")
    found = []
    for name, kind, place in made:
        own = free(names[name], taken)
        taken.add(own)
        found.append(ControlSensor(own, kind, frames[place]))
    return tuple(found), left_out


def _frames(written: Written, description: Description) -> Iterator[tuple[str, str]]:
    """(name of a site, frame or link, the link of the package that is there)."""
    own = description.names.links
    here = {link.name: link.name for link in written.as_urdf.robot.links}
    here |= {
        site.name: site.link
        for site in written.sensing.sites
        if site.link in here and np.array_equal(site.link_from_site, np.eye(4))
    }
    here |= written.urdf_names.frames
    # The user's own XML may have taken a link away.
    yield from ((name, own[link]) for name, link in here.items() if link in own)


def stem_of_names(names: Sequence[str]) -> str:
    """The one name, or what several have before their last "_"; "" where that differs."""
    if len(names) == 1:
        return names[0]
    stems = {name.rpartition("_")[0] for name in names}
    return stems.pop() if len(stems) == 1 else ""
