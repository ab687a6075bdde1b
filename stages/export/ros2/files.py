"""Fills the templates of a ROS 2 package: launch files, parameters, `package.xml` and others."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkwright.stages.formats.templates import Templates, xml_text
from linkwright.stages.robot.model.poses import inverse

if TYPE_CHECKING:
    from linkwright.stages.export.ground.standing import Placement

LAUNCH_PACKAGES = (
    "ament_index_python",
    "joint_state_publisher",
    "joint_state_publisher_gui",
    "launch",
    "launch_ros",
    "robot_state_publisher",
    "rviz2",
    "xacro",
)
"""Packages that the launch files need."""

CONTROL_PACKAGES = ("controller_manager", "hardware_interface", "python3-yaml")
"""Packages that ros2_control needs beside its controllers; mock hardware is part of hardware_interface."""

MOVEIT_PACKAGES = (
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
"""Packages that MoveIt's launch file needs."""

_DEFAULT_SIZE = 1.0
"""Size [m] to which the view is fitted if the robot has no shapes."""

_TEMPLATES = Templates(
    Path(__file__).with_name("templates"), {"json": json.dumps, "xml": xml_text, "bool": bool}
)
"""The templates. JSON is valid YAML, in which a name in double quotes is always a text."""


def fill_template(name: str, /, **values: Any) -> bytes:
    """Returns the file that the template of this name makes with the values."""
    return _TEMPLATES.filled(name, **values).encode()


def view_of(standing: "Placement") -> dict[str, float]:
    """Returns the view of RViz on the robot, in the frame of its root link: the lengths [m] of the grid, of
    frames and of the distance, and the position [m] of its middle."""
    low, high = standing.low, standing.high
    size, centre = _DEFAULT_SIZE, np.zeros(3)
    if np.isfinite(low).all() and np.isfinite(high).all():
        size = float(np.linalg.norm(high - low))
        centre = (inverse(standing.world_from_root) @ [*(low + high) / 2, 1.0])[:3]
    lengths = {
        "cell": size / 4,
        "marker": size / 3,
        "distance": 2 * size,
        **dict(zip("xyz", centre, strict=True)),
    }
    # -0 becomes 0.
    return {name: round(float(length), 3) + 0.0 for name, length in lengths.items()}


def cmake_lists(package: str, paths: Iterable[str]) -> bytes:
    """Returns the file CMakeLists.txt, which installs every file of the package in its folder. `paths`: the
    files' paths in the package."""
    paths = list(paths)
    root_files = sorted(path for path in paths if "/" not in path)
    folders = sorted({path.partition("/")[0] for path in paths if "/" in path})
    return fill_template("CMakeLists.txt", package=package, single=root_files, folders=folders)
