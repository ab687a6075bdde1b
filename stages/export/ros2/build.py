"""Writes all files of the format, from what the other modules of this room make of the robot."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from linkwright.stages.export import VERSION
from linkwright.stages.export.package_names import package_of
from linkwright.stages.export.ros2.control import Control, Ros2Plan, control_of
from linkwright.stages.export.ros2.controllers import Controller, controllers_of
from linkwright.stages.export.ros2.description import Description, described
from linkwright.stages.export.ros2.files import ALWAYS, CONTROLLED, MOVEIT, cmake_lists, filled, view_of
from linkwright.stages.export.ros2.moveit import Semantics, semantic_files, semantics_of
from linkwright.stages.export.ros2.names import macro_of, moveit_package_of
from linkwright.stages.export.ros2.section import Ros2FormatSection
from linkwright.stages.export.ros2.trajectories import trajectories_of
from linkwright.stages.export.ros2.xacro_files import control_macro, entry, macro
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput
from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.robot_json.files import PackageRecord, RenamedRecord
from linkwright.stages.formats.xml import to_bytes
from linkwright.stages.robot.text.names import free

FOLDER = "ros2"
"""Where the package lies in the output: a folder that can be a workspace's `src`."""


@dataclass(frozen=True, slots=True)
class Driven:
    """How the robot is driven. `trajectories`: the joints of each controller that follows trajectories."""

    control: Control
    controllers: tuple[Controller, ...]
    trajectories: Mapping[str, Sequence[str]]


def write(given: WriterInput) -> FormatFiles:
    """Its files, with copies of the meshes, and those of MoveIt's package beside it."""
    robot = given.written.robot
    keys = given.keys.export.ros2 or Ros2FormatSection()
    package = keys.package or package_of(robot.name)
    description = described(given.files[f"{robot.name}.urdf"], package)
    control = control_of(given.written, description)
    semantics = semantics_of(given.files[f"{robot.name}.srdf"], description)
    trajectories = trajectories_of(control.commanded("position"), semantics)
    controllers = controllers_of(control, trajectories)
    driven = Driven(control, controllers, trajectories)
    place = f"{FOLDER}/{package}"
    beside = _beside(given, package, description, semantics, driven)
    case = Case("ros2", given.written, robot, place, Ros2Plan(description, control, bool(beside)))
    files = {f"{place}/{path}": data for path, data in _files(given, package, description, driven)}
    files |= beside
    record = PackageRecord(package, VERSION, renamed=RenamedRecord.from_model(description.names))
    return FormatFiles(files, (case,), record={"ros2": record})


def _files(
    given: WriterInput, package: str, description: Description, driven: Driven
) -> list[tuple[str, bytes]]:
    """(path in the package, bytes)."""
    name = given.written.robot.name
    own = macro_of(name)
    parts = f"{name}_macro.xacro", f"{name}.ros2_control.xacro"
    joints = {str(one.get("name")) for one in description.root.iterchildren("joint")}
    control, controllers = driven.control, driven.controllers
    texts = {"package": package, "robot": name, "root": description.base}
    # A parameter of ROS that is given as a whole number is no real one.
    home = {one.name: float(number(one.home, least=1.0)) for one in control.joints if not one.follows}
    files = [
        (f"urdf/{parts[0]}", macro(description, own, free(f"{description.base}_mount", joints))),
        (f"urdf/{parts[1]}", control_macro(control, own)),
        (f"urdf/{name}.urdf.xacro", entry(name, description, control, own, parts)),
        (f"urdf/{name}.urdf", to_bytes(description.root)),
        (f"rviz/{name}.rviz", filled("robot.rviz", root=description.base, **view_of(given.standing))),
        ("launch/display.launch.py", filled("display.launch.py", **texts, home=home)),
        *((f"meshes/{file}", data) for file, data in given.written.shapes.files.items()),
    ]
    needs = [*ALWAYS]
    if controllers:
        driver = {"controllers": controllers, "plugin": control.plugin}
        files.append(("config/controllers.yaml", filled("controllers.yaml", controllers=controllers)))
        files.append(("launch/control.launch.py", filled("control.launch.py", **texts, **driver)))
        needs += [*CONTROLLED, *(one.package for one in controllers)]
    what = f"The robot {name}: URDF, meshes, ros2_control and launch files."
    return files + _manifests(given, package, what, needs, [path for path, _ in files])


def _manifests(
    given: WriterInput, package: str, what: str, needs: Sequence[str], paths: Sequence[str]
) -> list[tuple[str, bytes]]:
    """What makes a folder with files at these paths a package of ROS. `what`: its description; `needs`: the
    packages that it runs with."""

    keys, needs = given.keys.export.ros2 or Ros2FormatSection(), sorted(set(needs))
    about = filled("package.xml", package=package, what=what, keys=keys, needs=needs)
    return [("package.xml", about), ("CMakeLists.txt", cmake_lists(package, paths))]


def _beside(
    given: WriterInput, package: str, description: Description, semantics: Semantics, driven: Driven
) -> dict[str, bytes]:
    """The files of MoveIt's package by path: none where the configuration wants none, or nothing moves."""
    name, keys = given.written.robot.name, given.keys.export.ros2 or Ros2FormatSection()
    if not keys.moveit or not semantics.groups:
        return {}
    own = moveit_package_of(package)
    texts = {"package": own, "description": package, "robot": name, "root": description.base}
    frame = semantics.world or description.base
    files = [
        *semantic_files(name, semantics, description, driven.trajectories),
        ("config/moveit.rviz", filled("moveit.rviz", frame=frame, group=semantics.groups[0])),
        (
            "launch/moveit.launch.py",
            filled("moveit.launch.py", **texts, world=semantics.world, driven=driven),
        ),
        (".setup_assistant", filled("setup_assistant.yaml", **texts, keys=keys)),
    ]
    what = f"MoveIt for the robot {name}: groups, poses, kinematics, limits, controllers and a launch file."
    files += _manifests(given, own, what, [*MOVEIT, package], [path for path, _ in files])
    return {f"{FOLDER}/{own}/{path}": data for path, data in files}
