"""What starts MoveIt for a robot, and what RViz then shows."""

from collections.abc import Mapping

from linkwright.stages.export.ros2.launch_files import filled

_MOVEIT = '''"""Starts MoveIt for @ROBOT@, with RViz, and ros2_control with mock hardware.

    ros2 launch @PACKAGE@ moveit.launch.py
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from moveit_configs_utils import MoveItConfigsBuilder

ROOT = "@ROOT@"
WORLD = "@WORLD@"
"""The frame in which MoveIt plans, if that is not the root link."""

CONTROLLED = @CONTROLLED@
"""Whether there is a ros2_control to start."""

EXECUTES = @EXECUTES@
"""Whether a controller follows trajectories."""

ARGUMENTS = {
    "rviz": ("true", "whether RViz is started"),
    "robot": ("true", "whether what publishes the states of the joints is started, too"),
    "stand": ("true", "whether the root link stands at the origin of " + (WORLD or ROOT)),
    "use_mock_hardware": ("true", "whether joints just do what they are told"),
    "hardware_plugin": ("@PLUGIN@", "the plugin of the hardware, without mock hardware"),
}


def start(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    hardware = {name: given[name] for name in ("use_mock_hardware", "hardware_plugin")}
    config = (
        MoveItConfigsBuilder("@ROBOT@", package_name="@PACKAGE@")
        .robot_description(mappings=hardware)
        .planning_pipelines(pipelines=["ompl", "pilz_industrial_motion_planner"])
        .to_moveit_configs()
    )
    own = {"publish_robot_description_semantic": True, "allow_trajectory_execution": EXECUTES}
    nodes = [
        Node(
            package="moveit_ros_move_group",
            executable="move_group",
            output="screen",
            parameters=[config.to_dict(), own],
        )
    ]
    if WORLD and given["stand"] == "true":
        frames = ["--frame-id", WORLD, "--child-frame-id", ROOT]
        nodes.append(Node(package="tf2_ros", executable="static_transform_publisher", arguments=frames))
    if given["robot"] == "true" and CONTROLLED:
        file = Path(get_package_share_directory("@DESCRIPTION@")) / "launch" / "control.launch.py"
        source = PythonLaunchDescriptionSource(str(file))
        nodes.append(IncludeLaunchDescription(source, launch_arguments={**hardware, "rviz": "false"}.items()))
    elif given["robot"] == "true":
        nodes += [
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                parameters=[config.robot_description],
            ),
            Node(package="joint_state_publisher", executable="joint_state_publisher"),
        ]
    if given["rviz"] == "true":
        view = Path(get_package_share_directory("@PACKAGE@")) / "config" / "moveit.rviz"
        parameters = [
            config.robot_description,
            config.robot_description_semantic,
            config.robot_description_kinematics,
            config.planning_pipelines,
            config.joint_limits,
        ]
        nodes.append(
            Node(package="rviz2", executable="rviz2", arguments=["-d", str(view)], parameters=parameters)
        )
    return nodes
@DESCRIBE@'''

_RVIZ = """Panels:
  - Class: rviz_common/Displays
    Name: Displays
  - Class: rviz_common/Views
    Name: Views
Visualization Manager:
  Class: ""
  Displays:
    - Class: rviz_default_plugins/Grid
      Name: Grid
      Enabled: true
      Value: true
      Reference Frame: <Fixed Frame>
    - Class: moveit_rviz_plugin/MotionPlanning
      Name: MotionPlanning
      Enabled: true
      Value: true
      Move Group Namespace: ""
      Robot Description: robot_description
      Planning Scene Topic: monitored_planning_scene
      Planning Request:
        Planning Group: "@GROUP@"
  Global Options:
    Background Color: 48; 48; 48
    Fixed Frame: "@FRAME@"
    Frame Rate: 30
  Tools:
    - Class: rviz_default_plugins/Interact
    - Class: rviz_default_plugins/MoveCamera
    - Class: rviz_default_plugins/FocusCamera
  Views:
    Current:
      Class: rviz_default_plugins/Orbit
      Name: Current View
"""


def moveit_launch(given: Mapping[str, str]) -> bytes:
    """`launch/moveit.launch.py`. `given`: what stands for each `@KEY@`."""
    return filled(_MOVEIT, given)


def moveit_rviz(frame: str, group: str) -> bytes:
    """`config/moveit.rviz`: planning for a group, in a frame."""
    return filled(_RVIZ, {"FRAME": frame, "GROUP": group})
