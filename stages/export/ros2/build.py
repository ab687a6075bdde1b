"""Writes all files of the format ROS 2, and those of MoveIt's package."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from linkwright.stages.export import VERSION
from linkwright.stages.export.package_names import package_of
from linkwright.stages.export.ros2.control import Control, Ros2Plan, control_of
from linkwright.stages.export.ros2.controllers import Controller, controllers_of
from linkwright.stages.export.ros2.description import Description, description_of
from linkwright.stages.export.ros2.files import (
    CONTROL_PACKAGES,
    LAUNCH_PACKAGES,
    MOVEIT_PACKAGES,
    cmake_lists,
    fill_template,
    view_of,
)
from linkwright.stages.export.ros2.moveit import Semantics, semantic_files, semantics_of
from linkwright.stages.export.ros2.names import macro_of, moveit_package_of
from linkwright.stages.export.ros2.section import Ros2FormatSection
from linkwright.stages.export.ros2.trajectories import trajectories_of
from linkwright.stages.export.ros2.xacro_files import control_macro, entry_file, robot_macro
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput
from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.robot_json.files import NameChangesRecord, PackageRecord
from linkwright.stages.formats.xml import to_bytes
from linkwright.stages.robot.text.names import free_name

PACKAGES_FOLDER = "ros2"
"""Folder of the packages in the output, which can be the folder `src` of a workspace."""


@dataclass(frozen=True, slots=True)
class ControllerPlan:
    """The content of ros2_control, and the controllers that use it."""

    control: Control
    controllers: tuple[Controller, ...]

    trajectories: Mapping[str, Sequence[str]]
    """Name of each controller that follows trajectories → its joints."""


def write(inputs: WriterInput) -> FormatFiles:
    """Returns the files of the package, with copies of the meshes, and those of MoveIt's package beside
    it."""
    robot = inputs.written.robot
    keys = inputs.keys.export.ros2 or Ros2FormatSection()
    package = keys.package or package_of(robot.name)
    description = description_of(inputs.files[f"{robot.name}.urdf"], package)
    control = control_of(inputs.written, description)
    semantics = semantics_of(inputs.files[f"{robot.name}.srdf"], description)
    trajectories = trajectories_of(control.commanded("position"), semantics)
    controllers = controllers_of(control, trajectories)
    controller_plan = ControllerPlan(control, controllers, trajectories)
    folder = f"{PACKAGES_FOLDER}/{package}"
    moveit_files = _moveit_files(inputs, package, description, semantics, controller_plan)
    case = Case("ros2", inputs.written, robot, folder, Ros2Plan(description, control, bool(moveit_files)))
    files = {f"{folder}/{path}": data for path, data in _files(inputs, package, description, controller_plan)}
    files |= moveit_files
    record = PackageRecord(package, VERSION, renamed=NameChangesRecord.from_model(description.names))
    return FormatFiles(files, (case,), record={"ros2": record})


def _files(
    inputs: WriterInput, package: str, description: Description, controller_plan: ControllerPlan
) -> list[tuple[str, bytes]]:
    """Returns (path in the package, bytes) of each file except the manifests and MoveIt's package."""
    name = inputs.written.robot.name
    macro_name = macro_of(name)
    macro_files = f"{name}_macro.xacro", f"{name}.ros2_control.xacro"
    joints = {str(element.get("name")) for element in description.root.iterchildren("joint")}
    mount = free_name(f"{description.base}_mount", joints)
    control, controllers = controller_plan.control, controller_plan.controllers
    texts = {"package": package, "robot": name, "root": description.base}
    # ROS would not accept a whole number for a real parameter.
    home = {joint.name: float(number(joint.home, least=1.0)) for joint in control.joints if not joint.follows}
    meshes = inputs.written.shapes.shown(meshes=False, whole=True).files
    files = [
        (f"urdf/{macro_files[0]}", robot_macro(description, macro_name, mount)),
        (f"urdf/{macro_files[1]}", control_macro(control, macro_name)),
        (f"urdf/{name}.urdf.xacro", entry_file(name, description, control, macro_name, macro_files)),
        (f"urdf/{name}.urdf", to_bytes(description.root)),
        (f"rviz/{name}.rviz", fill_template("robot.rviz", root=description.base, **view_of(inputs.standing))),
        ("launch/display.launch.py", fill_template("display.launch.py", **texts, home=home)),
        *((f"meshes/{file}", data) for file, data in meshes.items()),
    ]
    required_packages = [*LAUNCH_PACKAGES]
    if controllers:
        control_values = {"controllers": controllers, "plugin": control.plugin}
        files.append(("config/controllers.yaml", fill_template("controllers.yaml", controllers=controllers)))
        files.append(
            ("launch/control.launch.py", fill_template("control.launch.py", **texts, **control_values))
        )
        required_packages += [*CONTROL_PACKAGES, *(controller.package for controller in controllers)]
    about = f"The robot {name}: URDF, meshes, ros2_control and launch files."
    return files + _manifests(inputs, package, about, required_packages, [path for path, _ in files])


def _manifests(
    inputs: WriterInput, package: str, about: str, required_packages: Sequence[str], paths: Sequence[str]
) -> list[tuple[str, bytes]]:
    """Returns the manifests that make a folder with files at these paths a package of ROS. `about`: its
    description; `required_packages`: the packages that it needs at run time."""
    keys, needs = inputs.keys.export.ros2 or Ros2FormatSection(), sorted(set(required_packages))
    manifest = fill_template("package.xml", package=package, what=about, keys=keys, needs=needs)
    return [("package.xml", manifest), ("CMakeLists.txt", cmake_lists(package, paths))]


def _moveit_files(
    inputs: WriterInput,
    package: str,
    description: Description,
    semantics: Semantics,
    controller_plan: ControllerPlan,
) -> dict[str, bytes]:
    """Returns the files of MoveIt's package by path; none if the configuration wants none, or if nothing
    moves."""
    name, keys = inputs.written.robot.name, inputs.keys.export.ros2 or Ros2FormatSection()
    if not keys.moveit or not semantics.groups:
        return {}
    moveit_package = moveit_package_of(package)
    texts = {"package": moveit_package, "description": package, "robot": name, "root": description.base}
    frame = semantics.world or description.base
    files = [
        *semantic_files(name, semantics, description, controller_plan.trajectories),
        ("config/moveit.rviz", fill_template("moveit.rviz", frame=frame, group=semantics.groups[0])),
        (
            "launch/moveit.launch.py",
            fill_template("moveit.launch.py", **texts, world=semantics.world, driven=controller_plan),
        ),
        (".setup_assistant", fill_template("setup_assistant.yaml", **texts, keys=keys)),
    ]
    about = f"MoveIt for the robot {name}: groups, poses, kinematics, limits, controllers and a launch file."
    files += _manifests(
        inputs, moveit_package, about, [*MOVEIT_PACKAGES, package], [path for path, _ in files]
    )
    return {f"{PACKAGES_FOLDER}/{moveit_package}/{path}": data for path, data in files}
