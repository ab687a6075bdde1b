"""The launch files of a ROS 2 package, and what RViz shows.

They expand the xacro file in their own process: a command line of xacro would have to quote what users give.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.formats.numbers import number
from linkwright.stages.robot.model.poses import inverse

if TYPE_CHECKING:
    from linkwright.stages.export.ground.standing import Stance

_DISPLAY = '''"""Shows @ROBOT@ in RViz, with sliders for its joints.

    ros2 launch @PACKAGE@ display.launch.py
"""

from pathlib import Path

import xacro
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ROOT = "@ROOT@"
HOME = {@HOME@}
"""Where the sliders start [rad or m]."""

ARGUMENTS = {
    "gui": ("true", "whether there are sliders for the joints"),
    "rviz": ("true", "whether RViz is started"),
    "prefix": ("", "what the names of links and joints begin with"),
    "parent": ("", "a link to put above the robot, as world"),
    "xyz": ("0 0 0", "where the robot is on that link [m]"),
    "rpy": ("0 0 0", "how it is turned there [rad]"),
}


def start(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    share = Path(get_package_share_directory("@PACKAGE@"))
    mappings = {name: given[name] for name in ("prefix", "parent", "xyz", "rpy")}
    description = xacro.process_file(str(share / "urdf" / "@ENTRY@"), mappings=mappings).toxml()
    sliders = "joint_state_publisher_gui" if given["gui"] == "true" else "joint_state_publisher"
    zeros = {given["prefix"] + joint: value for joint, value in HOME.items()}
    nodes = [
        Node(
            package="robot_state_publisher",
            executable="robot_state_publisher",
            parameters=[{"robot_description": ParameterValue(description, value_type=str)}],
        ),
        Node(package=sliders, executable=sliders, parameters=[{"zeros": zeros}] if zeros else []),
    ]
@SHOW@@DESCRIBE@'''

_CONTROL = '''"""Starts the ros2_control of @ROBOT@, with mock hardware unless another plugin is named.

    ros2 launch @PACKAGE@ control.launch.py
"""

import tempfile
from pathlib import Path

import xacro
import yaml
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ROOT = "@ROOT@"
CONTROLLERS = [@CONTROLLERS@]

ARGUMENTS = {
    "rviz": ("false", "whether RViz is started"),
    "prefix": ("", "what the names of links and joints begin with"),
    "parent": ("", "a link to put above the robot, as world"),
    "xyz": ("0 0 0", "where the robot is on that link [m]"),
    "rpy": ("0 0 0", "how it is turned there [rad]"),
    "use_mock_hardware": ("true", "whether joints just do what they are told"),
    "hardware_plugin": ("@PLUGIN@", "the plugin of the hardware, without mock hardware"),
}


def controllers(share, prefix):
    """The path of the controllers' parameters, with the prefix before the names of joints and links."""
    path = share / "config" / "controllers.yaml"
    if not prefix:
        return str(path)
    tree = yaml.safe_load(path.read_text())
    for node in tree.values():
        own = node["ros__parameters"]
        if "joints" in own:
            own["joints"] = [prefix + joint for joint in own["joints"]]
        for key in ("sensor_name", "frame_id"):
            if key in own:
                own[key] = prefix + own[key]
    with tempfile.NamedTemporaryFile("w", suffix=".yaml", delete=False) as file:
        yaml.safe_dump(tree, file, sort_keys=False)
    return file.name


def start(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    share = Path(get_package_share_directory("@PACKAGE@"))
    mappings = {name: value for name, value in given.items() if name != "rviz"}
    description = xacro.process_file(str(share / "urdf" / "@ENTRY@"), mappings=mappings).toxml()
    nodes = [
        Node(
            package="robot_state_publisher",
            executable="robot_state_publisher",
            parameters=[{"robot_description": ParameterValue(description, value_type=str)}],
        ),
        Node(
            package="controller_manager",
            executable="ros2_control_node",
            parameters=[controllers(share, given["prefix"])],
            remappings=[("~/robot_description", "/robot_description")],
            output="both",
        ),
    ]
    nodes += [
        Node(
            package="controller_manager",
            executable="spawner",
            arguments=[name, "--controller-manager", "/controller_manager"],
        )
        for name in CONTROLLERS
    ]
@SHOW@@DESCRIBE@'''

_SHOW = """    if given["rviz"] == "true":
        config = str(share / "rviz" / "@RVIZ@")
        nodes.append(
            Node(package="rviz2", executable="rviz2", arguments=["-d", config, "-f", given["prefix"] + ROOT])
        )
    return nodes
"""
"""The end of `start` where RViz shows the robot."""

_DESCRIBE = """

def generate_launch_description():
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=start)])
"""
"""The end of every launch file: its arguments, and what it starts with them."""

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
      Cell Size: @CELL@
      Plane Cell Count: 10
    - Class: rviz_default_plugins/RobotModel
      Name: RobotModel
      Enabled: true
      Value: true
      Description Source: Topic
      Description Topic:
        Value: /robot_description
        Depth: 1
        History Policy: Keep Last
        Reliability Policy: Reliable
        Durability Policy: Transient Local
      Visual Enabled: true
      Collision Enabled: false
    - Class: rviz_default_plugins/TF
      Name: TF
      Enabled: false
      Value: false
      Marker Scale: @MARKER@
      Show Names: true
  Global Options:
    Background Color: 48; 48; 48
    Fixed Frame: "@ROOT@"
    Frame Rate: 30
  Tools:
    - Class: rviz_default_plugins/Interact
    - Class: rviz_default_plugins/MoveCamera
    - Class: rviz_default_plugins/FocusCamera
  Views:
    Current:
      Class: rviz_default_plugins/Orbit
      Name: Current View
      Distance: @DISTANCE@
      Focal Point:
        X: @X@
        Y: @Y@
        Z: @Z@
      Pitch: 0.4
      Yaw: 0.8
"""

_SIZE = 1.0
"""m: of a robot without shapes."""


def display_launch(given: Mapping[str, str], home: Mapping[str, float]) -> bytes:
    """`launch/display.launch.py`. `given`: see `filled`; `home`: values of the joints that have sliders."""
    rows = _rows(f'"{joint}": {_float(value)},' for joint, value in home.items())
    return filled(_DISPLAY, {**given, "HOME": rows})


def control_launch(given: Mapping[str, str], controllers: Sequence[str], plugin: str) -> bytes:
    """`launch/control.launch.py`. `plugin`: of the source's own hardware, "" for none."""
    rows = _rows(f'"{name}",' for name in controllers)
    return filled(_CONTROL, {**given, "CONTROLLERS": rows, "PLUGIN": plugin})


def rviz(root: str, standing: "Stance") -> bytes:
    """What RViz shows: the robot in the frame of its root link."""
    low, high = standing.low, standing.high
    size, centre = _SIZE, np.zeros(3)
    if np.isfinite(low).all() and np.isfinite(high).all():
        size = float(np.linalg.norm(high - low))
        centre = (inverse(standing.world_from_root) @ [*(low + high) / 2, 1.0])[:3]
    numbers = {
        "CELL": _rounded(size / 4),
        "MARKER": _rounded(size / 3),
        "DISTANCE": _rounded(2 * size),
        **dict(zip("XYZ", map(_rounded, centre), strict=True)),
    }
    return filled(_RVIZ, {"ROOT": root, **numbers})


def filled(text: str, given: Mapping[str, str]) -> bytes:
    """A text in which `@KEY@` stands for what is given, `@SHOW@` and `@DESCRIBE@` for ends of such files."""
    for key, value in {"SHOW": _SHOW, "DESCRIBE": _DESCRIBE, **given}.items():
        text = text.replace(f"@{key}@", value)
    return text.encode()


def _rows(lines: Iterable[str]) -> str:
    """What stands in brackets, each on a line of its own."""
    rows = "".join(f"\n    {line}" for line in lines)
    return f"{rows}\n" if rows else ""


def _float(value: float) -> str:
    # A parameter of ROS that is given as a whole number is no real one.
    return repr(float(number(value, least=1.0)))


def _rounded(value: float) -> str:
    return repr(round(float(value), 3) + 0.0)
