"""The controllers of a robot, and `config/controllers.yaml`, which describes them.

Joints that are commanded by position follow trajectories; speeds and efforts are passed on. A name in double
quotes is a text in YAML, whatever it is.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from linkwright.stages.export.ros2.control import Control
from linkwright.stages.robot.text.names import free

RATE = 100
"""Hz: the default of ros2_control."""

BROADCASTERS = {"imu": "imu_sensor_broadcaster", "force_torque": "force_torque_sensor_broadcaster"}
"""Kind of a sensor → the package of its broadcaster."""

CLASSES = {
    "joint_state_broadcaster": "joint_state_broadcaster/JointStateBroadcaster",
    "joint_trajectory_controller": "joint_trajectory_controller/JointTrajectoryController",
    "forward_command_controller": "forward_command_controller/ForwardCommandController",
    "imu_sensor_broadcaster": "imu_sensor_broadcaster/IMUSensorBroadcaster",
    "force_torque_sensor_broadcaster": "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster",
}
"""Package → its controller."""


@dataclass(frozen=True, slots=True)
class Controller:
    """A controller of a `package`. `parameters`: key → a YAML value."""

    name: str
    package: str
    parameters: tuple[tuple[str, str], ...] = ()


def controllers_of(control: Control, trajectories: Mapping[str, Sequence[str]]) -> tuple[Controller, ...]:
    """What there is to start, in that order. `trajectories`: the joints of each controller that follows
    trajectories, by its name."""
    if not control.joints and not control.sensors:
        return ()
    return tuple(_controllers(control, trajectories))


def _controllers(control: Control, trajectories: Mapping[str, Sequence[str]]) -> Iterator[Controller]:
    taken = {*trajectories, "velocity_controller", "effort_controller"}
    if control.joints:
        taken.add("joint_state_broadcaster")
        yield Controller("joint_state_broadcaster", "joint_state_broadcaster")
    for name, joints in trajectories.items():
        following = (
            ("joints", _listed(joints)),
            ("command_interfaces", _listed(["position"])),
            ("state_interfaces", _listed(["position", "velocity"])),
            # So that a planner can move a part of them.
            ("allow_partial_joints_goal", "true"),
        )
        yield Controller(name, "joint_trajectory_controller", following)
    by_position = control.commanded("position")
    for interface in ("velocity", "effort"):
        joints = [name for name in control.commanded(interface) if name not in by_position]
        if joints:
            parameters = (("joints", _listed(joints)), ("interface_name", json.dumps(interface)))
            yield Controller(f"{interface}_controller", "forward_command_controller", parameters)
    for sensor in control.sensors:
        name = free(f"{sensor.name}_broadcaster", taken)
        taken.add(name)
        own = (("sensor_name", json.dumps(sensor.name)), ("frame_id", json.dumps(sensor.frame)))
        yield Controller(name, BROADCASTERS[sensor.kind], own)


def controllers_yaml(controllers: tuple[Controller, ...]) -> bytes:
    """`config/controllers.yaml`."""
    lines = ["controller_manager:", "  ros__parameters:", f"    update_rate: {RATE}"]
    for one in controllers:
        lines += [f"    {one.name}:", f"      type: {CLASSES[one.package]}"]
    for one in controllers:
        if one.parameters:
            lines += ["", f"{one.name}:", "  ros__parameters:"]
            lines += [f"    {key}: {value}" for key, value in one.parameters]
    return ("\n".join(lines) + "\n").encode()


def _listed(names: Sequence[str]) -> str:
    return json.dumps(list(names))
