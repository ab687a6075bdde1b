"""The controllers of a robot.

Joints that are commanded by position follow trajectories; speeds and efforts are passed on.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from linkwright.stages.export.ros2.control import Control
from linkwright.stages.robot.text.names import free

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
    """A controller of a `package`, with its `parameters`."""

    name: str
    package: str
    parameters: Mapping[str, Any] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """The class that the package registers."""
        return CLASSES[self.package]


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
        following = {
            "joints": joints,
            "command_interfaces": ["position"],
            "state_interfaces": ["position", "velocity"],
            # So that a planner can move a part of them.
            "allow_partial_joints_goal": True,
        }
        yield Controller(name, "joint_trajectory_controller", following)
    by_position = control.commanded("position")
    for interface in ("velocity", "effort"):
        joints = [name for name in control.commanded(interface) if name not in by_position]
        if joints:
            parameters = {"joints": joints, "interface_name": interface}
            yield Controller(f"{interface}_controller", "forward_command_controller", parameters)
    for sensor in control.sensors:
        name = free(f"{sensor.name}_broadcaster", taken)
        taken.add(name)
        own = {"sensor_name": sensor.name, "frame_id": sensor.frame}
        yield Controller(name, BROADCASTERS[sensor.kind], own)
