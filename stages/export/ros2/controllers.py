"""Chooses the controllers of a robot.

Joints that are commanded by position follow trajectories. Speeds and efforts are passed on.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from linkwright.stages.export.ros2.control import Control
from linkwright.stages.robot.text.names import free_name

BROADCASTERS = {"imu": "imu_sensor_broadcaster", "force_torque": "force_torque_sensor_broadcaster"}
"""Kind of a sensor → the package of its broadcaster."""

CLASS_BY_PACKAGE = {
    "joint_state_broadcaster": "joint_state_broadcaster/JointStateBroadcaster",
    "joint_trajectory_controller": "joint_trajectory_controller/JointTrajectoryController",
    "forward_command_controller": "forward_command_controller/ForwardCommandController",
    "imu_sensor_broadcaster": "imu_sensor_broadcaster/IMUSensorBroadcaster",
    "force_torque_sensor_broadcaster": "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster",
}
"""Package → the class of its controller."""


@dataclass(frozen=True, slots=True)
class Controller:
    """A controller of ros2_control."""

    name: str

    package: str
    """The ROS package that has it."""

    parameters: Mapping[str, Any] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """Returns the class that the package registers."""
        return CLASS_BY_PACKAGE[self.package]


def controllers_of(control: Control, trajectories: Mapping[str, Sequence[str]]) -> tuple[Controller, ...]:
    """Returns the controllers in the order in which they start. `trajectories`: name of each controller that
    follows trajectories → its joints."""
    if not control.joints and not control.sensors:
        return ()
    return tuple(_controllers(control, trajectories))


def _controllers(control: Control, trajectories: Mapping[str, Sequence[str]]) -> Iterator[Controller]:
    """Yields the controllers: the broadcaster of joints, controllers of trajectories, of speeds and of
    efforts, and the broadcasters of sensors."""
    used_names = {*trajectories, "velocity_controller", "effort_controller"}
    if control.joints:
        used_names.add("joint_state_broadcaster")
        yield Controller("joint_state_broadcaster", "joint_state_broadcaster")
    for name, joints in trajectories.items():
        parameters_of_trajectory = {
            "joints": joints,
            "command_interfaces": ["position"],
            "state_interfaces": ["position", "velocity"],
            # With this, a planner can move some of the joints.
            "allow_partial_joints_goal": True,
        }
        yield Controller(name, "joint_trajectory_controller", parameters_of_trajectory)
    by_position = control.commanded("position")
    for interface in ("velocity", "effort"):
        joints = [name for name in control.commanded(interface) if name not in by_position]
        if joints:
            parameters = {"joints": joints, "interface_name": interface}
            yield Controller(f"{interface}_controller", "forward_command_controller", parameters)
    for sensor in control.sensors:
        name = free_name(f"{sensor.name}_broadcaster", used_names)
        used_names.add(name)
        parameters_of_sensor = {"sensor_name": sensor.name, "frame_id": sensor.frame}
        yield Controller(name, BROADCASTERS[sensor.kind], parameters_of_sensor)
