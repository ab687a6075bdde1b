"""Faults of the packages of ROS 2 and MoveIt."""

import random

from tests.support.mutations.kind import Files, NothingToChange, Planted
from tests.support.mutations.texts import Fault, kinds

PACKAGE, MOVEIT = "ros2/*_description", "ros2/*_moveit_config"
CONTROLLERS = f"{PACKAGE}/config/controllers.yaml"
CONTROL = f"{PACKAGE}/urdf/*.ros2_control.xacro"
MACRO, URDF, TOP = f"{PACKAGE}/urdf/*_macro.xacro", f"{PACKAGE}/urdf/*.urdf", f"{PACKAGE}/urdf/*.urdf.xacro"
LAUNCH, RVIZ = f"{PACKAGE}/launch/control.launch.py", f"{PACKAGE}/rviz/*.rviz"

OF_JOINT = r'<joint name="\$\{prefix\}(?P<joint>\w+)"'
JOINT = 'joint "${{prefix}}{joint}"'

KINDS = kinds(
    "ros2",
    "C-ROS2",
    Fault(
        "controller of a joint that is not there",
        CONTROLLERS,
        r'(?P<name>\w+):\n  ros__parameters:\n    joints: \["(?P<old>\w+)',
        "elbow_joint",
        "{name}",
        "joints",
    ),
    Fault(
        "controller without a joint",
        CONTROLLERS,
        r'(?P<name>\w+):\n  ros__parameters:\n    joints: \[(?P<old>"\w+", )',
        "",
        "{name}",
        "joints",
    ),
    Fault(
        "controller of another type",
        CONTROLLERS,
        r"(?P<name>\w+_controller):\n      type: (?P<old>\S+)",
        "velocity_controllers/JointGroupVelocityController",
        "controller_manager",
        "type",
    ),
    Fault(
        "controller of another interface",
        CONTROLLERS,
        r'(?P<name>\w+):\n  ros__p.*\n    joints.*\n    \w+: \[?"(?P<old>\w+)',
        "velocity",
        "{name}",
        "interface",
    ),
    Fault(
        "controller taken out",
        CONTROLLERS,
        r"(?P<old>    effort_controller:\n      type: .*\n)",
        "",
        "controller_manager",
        "effort_controller",
    ),
    Fault(
        "number of a controller as a text", CONTROLLERS, r"update_rate: (?P<old>\d+)", '"fast"', "controller"
    ),
    Fault("controllers not YAML", CONTROLLERS, r"(?P<old>joints: \[)", "joints: [[", "file"),
    Fault(
        "hardware's joint renamed",
        CONTROL,
        r'<joint name="\$\{prefix\}(?P<old>\w+)"',
        "axis_7",
        'joint "${{prefix}}axis_7"',
    ),
    Fault(
        "command of another interface",
        CONTROL,
        OF_JOINT + r'>\n\s*<command_interface name="(?P<old>\w+)',
        "velocity",
        JOINT,
        "command_interface",
    ),
    Fault(
        "command gone",
        CONTROL,
        OF_JOINT + r'>(?P<old>\n\s*<command_interface name="\w+"/>)',
        "",
        JOINT,
    ),
    Fault(
        "hardware starts elsewhere",
        CONTROL,
        r'<param name="initial_value">(?P<old>\S+)</param>',
        "0.9",
        "${{prefix}}",
        "initial_value",
    ),
    Fault(
        "hardware's mimic turned round",
        CONTROL,
        r'name="multiplier">(?P<old>\S+)<',
        "2",
        "joint",
        "multiplier",
    ),
    Fault(
        "another plugin of the hardware",
        CONTROL,
        r"<plugin>(?P<old>mock_components/GenericSystem)",
        "fake_components/GenericSystem",
        "ros2_control",
        "plugin",
    ),
    Fault("xacro's mass off", MACRO, r'<mass value="(?P<old>[^"]+)"', "0.987", "link", "mass value"),
    Fault(
        "xacro's limit off",
        MACRO,
        OF_JOINT + r'(?:(?!</joint>)[\s\S])*?<limit lower="(?P<old>[^"]+)"',
        "-0.123",
        JOINT,
        "limit lower",
    ),
    Fault(
        "xacro's joint elsewhere",
        MACRO,
        OF_JOINT + r'(?:(?!</joint>)[\s\S])*?<origin xyz="(?P<old>[-\d][^"]*)"',
        "0.01 0.02 0.03",
        JOINT,
        "origin xyz",
    ),
    Fault(
        "xacro's joint on another link",
        MACRO,
        OF_JOINT + r'(?:(?!</joint>)[\s\S])*?<child link="\$\{prefix\}(?P<old>\w+)"',
        "other",
        JOINT,
        "child link",
    ),
    Fault("prefix left out", MACRO, r'<link name="(?P<old>\$\{prefix\})\w+"', "", "link"),
    Fault(
        "include of another file", TOP, r'filename="(?P<old>\w+_macro.xacro)', "my.xacro", "robot", "include"
    ),
    Fault(
        "axis of the package's URDF turned round",
        URDF,
        r'<joint name="(?P<joint>\w+)"(?:(?!</joint>)[\s\S])*?<axis xyz="(?P<old>[^"]+)"',
        "0.6 0 -0.8",
        'joint "{joint}"',
        "axis xyz",
    ),
    Fault(
        "mesh of another package",
        URDF,
        r'filename="package://(?P<old>\w+)/',
        "meshes_only",
        "link",
        "mesh filename",
    ),
    Fault("launch of another root", LAUNCH, r'\nROOT = "(?P<old>\w+)"', "torso", 'constant "ROOT"'),
    Fault(
        "launch without a controller",
        LAUNCH,
        r'(?P<old>\n    "effort_controller",)',
        "",
        'constant "CONTROLLERS"',
    ),
    Fault("launch from another package", LAUNCH, r'share_directory\("(?P<old>\w+)', "other", 'def "start"'),
    Fault("launch not Python", LAUNCH, r"(?P<old>def start\()", "def start((", "file"),
    Fault(
        "view of another frame", RVIZ, r'Fixed Frame: "(?P<old>\w+)"', "map", "Visualization Manager", "Fixed"
    ),
    Fault(
        "view of another topic", RVIZ, r"Value: (?P<old>/robot_description)", "/arm", "Visualization", "Topic"
    ),
    Fault("package renamed", f"{PACKAGE}/package.xml", r"<name>(?P<old>\w+)<", "arm", "package", "name"),
    Fault(
        "dependency left out",
        f"{PACKAGE}/package.xml",
        r"(?P<old>  <exec_depend>\w+</exec_depend>\n)",
        "",
        "package",
        "exec_depend",
    ),
    Fault(
        "built by another tool",
        f"{PACKAGE}/package.xml",
        r"<build_type>(?P<old>\w+)",
        "ament_python",
        "package",
        "build_type",
    ),
    Fault("folder not installed", f"{PACKAGE}/CMakeLists.txt", r"(?P<old> meshes)", "", "install", "meshes"),
    Fault("project renamed", f"{PACKAGE}/CMakeLists.txt", r"project\((?P<old>\w+)", "arm", "project"),
    Fault(
        "MoveIt's speed of a joint",
        f"{MOVEIT}/config/joint_limits.yaml",
        r'"(?P<joint>\w+)":\n.*\n    max_velocity: (?P<old>\S+)',
        "77.0",
        "joint_limits",
        "max_velocity",
    ),
    Fault(
        "MoveIt's controller of another name",
        f"{MOVEIT}/config/moveit_controllers.yaml",
        r"controller_names: \[(?P<old>\w+)",
        "arm",
        "moveit_simple",
        "controller_names",
    ),
    Fault(
        "MoveIt's solver of a group gone",
        f"{MOVEIT}/config/kinematics.yaml",
        r'"(?P<name>\w+)":\n(?P<old>  kinematics_solver: \S+\n)',
        "",
        "{name}",
        "kinematics_solver",
    ),
    Fault(
        "MoveIt's SRDF is an old copy",
        f"{MOVEIT}/config/*.srdf",
        r'reason="(?P<old>Adjacent)"',
        "Never",
        "disable_collisions",
        "reason",
    ),
    Fault(
        "MoveIt's URDF elsewhere",
        f"{MOVEIT}/.setup_assistant",
        r'relative_path: "(?P<old>\S+)\.urdf',
        "arm",
        "moveit_setup",
        "relative_path",
    ),
)


@KINDS.add("mesh of a package gone", "C-ROS2")
def _(files: Files, rng: random.Random) -> Planted:
    mesh = rng.choice(sorted(files.folder.glob(f"{PACKAGE}/meshes/*.stl")))
    mesh.unlink()
    return Planted(f'file "{mesh.name}"', ("",))


@KINDS.add("mesh of a package is an old copy", "C-ROS2")
def _(files: Files, rng: random.Random) -> Planted:
    meshes = sorted(files.folder.glob(f"{PACKAGE}/meshes/*.stl"))
    mesh, other = rng.sample(meshes, 2)
    if mesh.read_bytes() == other.read_bytes():
        raise NothingToChange
    mesh.write_bytes(other.read_bytes())
    return Planted(f'file "{mesh.name}"', ("",))


@KINDS.add("file of a package gone", "C-ROS2")
def _(files: Files, rng: random.Random) -> Planted:
    paths = [path for path in files.folder.glob(f"{PACKAGE}/*/*") if path.suffix != ".stl"]
    rng.choice(sorted(paths)).unlink()
    return Planted("file", ("",))
