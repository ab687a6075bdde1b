"""Faults of a build's packages of ROS 2 and MoveIt."""

from tests.support.faults.edits import file_of, text
from tests.support.faults.fault import NothingToChange, table

PACKAGE, MOVEIT = "ros2/*_description", "ros2/*_moveit_config"
CONTROLLERS = f"{PACKAGE}/config/controllers.yaml"
CONTROL = f"{PACKAGE}/urdf/*.ros2_control.xacro"
MACRO, URDF, TOP = f"{PACKAGE}/urdf/*_macro.xacro", f"{PACKAGE}/urdf/*.urdf", f"{PACKAGE}/urdf/*.urdf.xacro"
LAUNCH, RVIZ = f"{PACKAGE}/launch/control.launch.py", f"{PACKAGE}/rviz/*.rviz"
MANIFEST, CMAKE = f"{PACKAGE}/package.xml", f"{PACKAGE}/CMakeLists.txt"

OF_JOINT = r'<joint name="\$\{prefix\}(?P<joint>\w+)"'
WITHIN = OF_JOINT + r"(?:(?!</joint>)[\s\S])*?"
PARAMETERS = r"(?P<name>\w+):\n  ros__parameters:\n    joints: "
JOINT = 'joint "${{prefix}}{joint}"'


def mesh_gone(files, rng):
    mesh = file_of(files.folder, f"{PACKAGE}/meshes/*.stl", rng)
    mesh.unlink()
    return f'file "{mesh.name}"'


def mesh_of_another(files, rng):
    mesh, other = rng.sample(sorted(files.folder.glob(f"{PACKAGE}/meshes/*.stl")), 2)
    if mesh.read_bytes() == other.read_bytes():
        raise NothingToChange
    mesh.write_bytes(other.read_bytes())
    return f'file "{mesh.name}"'


def file_gone(files, rng):
    paths = [path for path in files.folder.glob(f"{PACKAGE}/*/*") if path.suffix != ".stl"]
    rng.choice(sorted(paths)).unlink()
    return "file"


FAULTS = table(
    "ros2",
    ("controller of a joint that is not there", text(CONTROLLERS, PARAMETERS + r'\["(?P<old>\w+)',
     "elbow_joint", "{name}"), "C-ROS2: joints"),
    ("controller without a joint", text(CONTROLLERS, PARAMETERS + r'\[(?P<old>"\w+", )',
     "", "{name}"), "C-ROS2: joints"),
    ("controller of another type", text(CONTROLLERS, r"(?P<name>\w+_controller):\n      type: (?P<old>\S+)",
     "velocity_controllers/JointGroupVelocityController", "controller_manager"), "C-ROS2: type"),
    ("controller of another interface",
     text(CONTROLLERS, r'(?P<name>\w+):\n  ros__p.*\n    joints.*\n    \w+: \[?"(?P<old>\w+)',
     "velocity", "{name}"), "C-ROS2: interface"),
    ("controller taken out", text(CONTROLLERS, r"(?P<old>    effort_controller:\n      type: .*\n)",
     "", "controller_manager"), "C-ROS2: effort_controller"),
    ("number of a controller as a text",
     text(CONTROLLERS, r"update_rate: (?P<old>\d+)", '"fast"', "controller"), "C-ROS2: "),
    ("controllers not YAML", text(CONTROLLERS, r"(?P<old>joints: \[)", "joints: [[", "file"), "C-ROS2: "),
    ("hardware's joint renamed", text(CONTROL, r'<joint name="\$\{prefix\}(?P<old>\w+)"',
     "axis_7", 'joint "${{prefix}}axis_7"'), "C-ROS2: "),
    ("command of another interface", text(CONTROL, OF_JOINT + r'>\n\s*<command_interface name="(?P<old>\w+)',
     "velocity", JOINT), "C-ROS2: command_interface"),
    ("command gone", text(CONTROL, OF_JOINT + r'>(?P<old>\n\s*<command_interface name="\w+"/>)', "", JOINT),
     "C-ROS2: "),
    ("hardware starts elsewhere", text(CONTROL, r'<param name="initial_value">(?P<old>\S+)</param>',
     "0.9", "${{prefix}}"), "C-ROS2: initial_value"),
    ("hardware's mimic turned round", text(CONTROL, r'name="multiplier">(?P<old>\S+)<', "2", "joint"),
     "C-ROS2: multiplier"),
    ("another plugin of the hardware", text(CONTROL, r"<plugin>(?P<old>mock_components/GenericSystem)",
     "fake_components/GenericSystem", "ros2_control"), "C-ROS2: plugin"),
    ("xacro's mass off", text(MACRO, r'<mass value="(?P<old>[^"]+)"', "0.987", "link"), "C-ROS2: mass value"),
    ("xacro's limit off", text(MACRO, WITHIN + r'<limit lower="(?P<old>[^"]+)"',
     "-0.123", JOINT), "C-ROS2: limit lower"),
    ("xacro's joint elsewhere", text(MACRO, WITHIN + r'<origin xyz="(?P<old>[-\d][^"]*)"',
     "0.01 0.02 0.03", JOINT), "C-ROS2: origin xyz"),
    ("xacro's joint on another link", text(MACRO, WITHIN + r'<child link="\$\{prefix\}(?P<old>\w+)"',
     "other", JOINT), "C-ROS2: child link"),
    ("prefix left out", text(MACRO, r'<link name="(?P<old>\$\{prefix\})\w+"', "", "link"), "C-ROS2: "),
    ("include of another file", text(TOP, r'filename="(?P<old>\w+_macro.xacro)', "my.xacro", "robot"),
     "C-ROS2: include"),
    ("axis of the package's URDF turned round",
     text(URDF, r'<joint name="(?P<joint>\w+)"(?:(?!</joint>)[\s\S])*?<axis xyz="(?P<old>[^"]+)"',
     "0.6 0 -0.8", 'joint "{joint}"'), "C-ROS2: axis xyz"),
    ("mesh of another package", text(URDF, r'filename="package://(?P<old>\w+)/', "meshes_only", "link"),
     "C-ROS2: mesh filename"),
    ("launch of another root", text(LAUNCH, r'\nROOT = "(?P<old>\w+)"', "torso", 'constant "ROOT"'),
     "C-ROS2: "),
    ("launch without a controller",
     text(LAUNCH, r'(?P<old>\n    "effort_controller",)', "", 'constant "CONTROLLERS"'), "C-ROS2: "),
    ("launch from another package", text(LAUNCH, r'share_directory\("(?P<old>\w+)', "other", 'def "start"'),
     "C-ROS2: "),
    ("launch not Python", text(LAUNCH, r"(?P<old>def start\()", "def start((", "file"), "C-ROS2: "),
    ("view of another frame", text(RVIZ, r'Fixed Frame: "(?P<old>\w+)"', "map", "Visualization Manager"),
     "C-ROS2: Fixed"),
    ("view of another topic", text(RVIZ, r"Value: (?P<old>/robot_description)", "/arm", "Visualization"),
     "C-ROS2: Topic"),
    ("package renamed", text(MANIFEST, r"<name>(?P<old>\w+)<", "arm", "package"),
     "C-ROS2: name"),
    ("dependency left out", text(MANIFEST, r"(?P<old>  <exec_depend>\w+</exec_depend>\n)",
     "", "package"), "C-ROS2: exec_depend"),
    ("built by another tool", text(MANIFEST, r"<build_type>(?P<old>\w+)",
     "ament_python", "package"), "C-ROS2: build_type"),
    ("folder not installed", text(CMAKE, r"(?P<old> meshes)", "", "install"),
     "C-ROS2: meshes"),
    ("project renamed", text(CMAKE, r"project\((?P<old>\w+)", "arm", "project"),
     "C-ROS2: "),
    ("MoveIt's speed of a joint",
     text(f"{MOVEIT}/config/joint_limits.yaml", r'"(?P<joint>\w+)":\n.*\n    max_velocity: (?P<old>\S+)',
     "77.0", "joint_limits"), "C-ROS2: max_velocity"),
    ("MoveIt's controller of another name",
     text(f"{MOVEIT}/config/moveit_controllers.yaml", r"controller_names: \[(?P<old>\w+)",
     "arm", "moveit_simple"), "C-ROS2: controller_names"),
    ("MoveIt's solver of a group gone",
     text(f"{MOVEIT}/config/kinematics.yaml", r'"(?P<name>\w+)":\n(?P<old>  kinematics_solver: \S+\n)',
     "", "{name}"), "C-ROS2: kinematics_solver"),
    ("MoveIt's SRDF is an old copy", text(f"{MOVEIT}/config/*.srdf", r'reason="(?P<old>Adjacent)"',
     "Never", "disable_collisions"), "C-ROS2: reason"),
    ("MoveIt's URDF elsewhere", text(f"{MOVEIT}/.setup_assistant", r'relative_path: "(?P<old>\S+)\.urdf',
     "arm", "moveit_setup"), "C-ROS2: relative_path"),
    ("mesh of a package gone", mesh_gone, "C-ROS2: "),
    ("mesh of a package is an old copy", mesh_of_another, "C-ROS2: "),
    ("file of a package gone", file_gone, "C-ROS2: "),
)  # fmt: skip
