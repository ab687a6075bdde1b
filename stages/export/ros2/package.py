"""`package.xml` (format 3, REP 149) and `CMakeLists.txt` of a ROS 2 package."""

from collections.abc import Collection, Iterable

from linkwright.stages.export.ros2.section import Ros2FormatSection
from linkwright.stages.formats.xml import element, to_bytes

ALWAYS = (
    "ament_index_python",
    "joint_state_publisher",
    "joint_state_publisher_gui",
    "launch",
    "launch_ros",
    "robot_state_publisher",
    "rviz2",
    "xacro",
)
"""What the launch files need."""

CONTROLLED = ("controller_manager", "hardware_interface", "python3-yaml")
"""What ros2_control needs beside its controllers; mock hardware is part of hardware_interface."""

_SCHEMA = (
    b'<?xml-model href="http://download.ros.org/schema/package_format3.xsd"'
    b' schematypens="http://www.w3.org/2001/XMLSchema"?>\n'
)


MOVEIT = (
    "ament_index_python",
    "joint_state_publisher",
    "launch",
    "launch_ros",
    "moveit_configs_utils",
    "moveit_kinematics",
    "moveit_planners",
    "moveit_ros_move_group",
    "moveit_ros_visualization",
    "moveit_simple_controller_manager",
    "robot_state_publisher",
    "rviz2",
    "tf2_ros",
)
"""What MoveIt's launch file needs."""


def package_xml(package: str, what: str, keys: Ros2FormatSection, needs: Collection[str]) -> bytes:
    """`what`: its description; `needs`: the packages that this one runs with."""
    root = element(None, "package", format="3")
    element(root, "name").text = package
    element(root, "version").text = keys.version
    element(root, "description").text = what
    element(root, "maintainer", email=keys.email).text = keys.maintainer
    element(root, "license").text = keys.license
    element(root, "buildtool_depend").text = "ament_cmake"
    for name in sorted(set(needs)):
        element(root, "exec_depend").text = name
    export = element(root, "export")
    element(export, "build_type").text = "ament_cmake"
    head, _, rest = to_bytes(root).partition(b"\n")
    return head + b"\n" + _SCHEMA + rest


def cmake_lists(package: str, paths: Iterable[str]) -> bytes:
    """Installs every file of the package, in its folder. `paths`: of these files, in the package."""
    paths = list(paths)
    single = " ".join(sorted(path for path in paths if "/" not in path))
    loose = f"\ninstall(\n  FILES {single}\n  DESTINATION share/${{PROJECT_NAME}}\n)\n" if single else ""
    folders = " ".join(sorted({path.partition("/")[0] for path in paths if "/" in path}))
    text = f"""cmake_minimum_required(VERSION 3.8)
project({package})

find_package(ament_cmake REQUIRED)

install(
  DIRECTORY {folders}
  DESTINATION share/${{PROJECT_NAME}}
)
{loose}
ament_package()
"""
    return text.encode()
