"""A ROS 2 package: the folder that `colcon build` takes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from linkwright.stages.export.writer import FormatFiles, WriterInput

if TYPE_CHECKING:
    from linkwright.stages.export.ros2.control import Control
    from linkwright.stages.export.ros2.controllers import Controller
    from linkwright.stages.export.ros2.description import Description
    from linkwright.stages.export.ros2.moveit import Semantics

FOLDER = "ros2"
"""Where the package lies in the output: a folder that can be a workspace's `src`."""


@dataclass(frozen=True, slots=True)
class Driven:
    """How the robot is driven. `trajectories`: the joints of each controller that follows trajectories."""

    control: "Control"
    controllers: "tuple[Controller, ...]"
    trajectories: Mapping[str, Sequence[str]]


class Ros2Writer:
    """`ros2/<package>/`, and MoveIt's package beside it."""

    reads: tuple[str, ...] = ("urdf",)
    modules: tuple[str, ...] = (
        "linkwright.stages.export.ros2.xacro_files",
        "linkwright.stages.export.ros2.launch_files",
        "linkwright.stages.export.ros2.moveit",
    )

    def paths(self, robot: str) -> tuple[str, ...]:
        return (f"{FOLDER}/*",)

    def write(self, given: WriterInput) -> FormatFiles:
        """Its files, with copies of the meshes, and those of MoveIt's package beside it."""
        from linkwright.stages.export import VERSION
        from linkwright.stages.export.package_names import package_of
        from linkwright.stages.export.ros2.control import control_of
        from linkwright.stages.export.ros2.controllers import controllers_of
        from linkwright.stages.export.ros2.description import described
        from linkwright.stages.export.ros2.moveit import semantics_of
        from linkwright.stages.export.ros2.section import Ros2FormatSection
        from linkwright.stages.export.ros2.trajectories import trajectories_of
        from linkwright.stages.export.ros2.unsupported import unsupported
        from linkwright.stages.formats.robot_json.files import PackageRecord, RenamedRecord

        robot = given.written.robot
        keys = given.keys.export.ros2 or Ros2FormatSection()
        package = keys.package or package_of(robot.name)
        description = described(given.files[f"{robot.name}.urdf"], package)
        control = control_of(given.written, description)
        semantics = semantics_of(given.files[f"{robot.name}.srdf"], description)
        trajectories = trajectories_of(control.commanded("position"), semantics)
        controllers = controllers_of(control, trajectories)
        driven = Driven(control, controllers, trajectories)
        own = description.root.find("ros2_control") is not None
        place = f"{FOLDER}/{package}"
        beside = _beside(given, package, description, semantics, driven)
        told = tuple(unsupported(description.names, control, own, place, bool(beside)))
        files = {f"{place}/{path}": data for path, data in _files(given, package, description, driven)}
        files |= beside
        record = PackageRecord(package, VERSION, renamed=RenamedRecord.from_model(description.names))
        return FormatFiles(files, told, record={"ros2": record})


def _files(
    given: WriterInput, package: str, description: "Description", driven: Driven
) -> list[tuple[str, bytes]]:
    """(path in the package, bytes)."""
    from linkwright.stages.export.ros2.controllers import controllers_yaml
    from linkwright.stages.export.ros2.launch_files import control_launch, display_launch, rviz
    from linkwright.stages.export.ros2.names import macro_of
    from linkwright.stages.export.ros2.package import ALWAYS, CONTROLLED, cmake_lists, package_xml
    from linkwright.stages.export.ros2.section import Ros2FormatSection
    from linkwright.stages.export.ros2.xacro_files import control_macro, entry, macro
    from linkwright.stages.formats.xml import to_bytes
    from linkwright.stages.robot.text.names import free

    name = given.written.robot.name
    keys = given.keys.export.ros2 or Ros2FormatSection()
    own = macro_of(name)
    parts = f"{name}_macro.xacro", f"{name}.ros2_control.xacro"
    joints = {str(one.get("name")) for one in description.root.iterchildren("joint")}
    control, controllers = driven.control, driven.controllers
    texts = {
        "PACKAGE": package,
        "ROBOT": name,
        "ROOT": description.base,
        "ENTRY": f"{name}.urdf.xacro",
        "RVIZ": f"{name}.rviz",
    }
    home = {one.name: one.home for one in control.joints if not one.follows}
    files = [
        (f"urdf/{parts[0]}", macro(description, own, free(f"{description.base}_mount", joints))),
        (f"urdf/{parts[1]}", control_macro(control, own)),
        (f"urdf/{name}.urdf.xacro", entry(name, description, control, own, parts)),
        (f"urdf/{name}.urdf", to_bytes(description.root)),
        (f"rviz/{name}.rviz", rviz(description.base, given.standing)),
        ("launch/display.launch.py", display_launch(texts, home)),
        *((f"meshes/{file}", data) for file, data in given.written.shapes.files.items()),
    ]
    needs = [*ALWAYS]
    if controllers:
        plugin = control.plugin
        files.append(("config/controllers.yaml", controllers_yaml(controllers)))
        files.append(
            ("launch/control.launch.py", control_launch(texts, [one.name for one in controllers], plugin))
        )
        needs += [*CONTROLLED, *(one.package for one in controllers)]
    what = f"The robot {name}: URDF, meshes, ros2_control and launch files."
    paths = [path for path, _ in files]
    files.append(("package.xml", package_xml(package, what, keys, needs)))
    files.append(("CMakeLists.txt", cmake_lists(package, paths)))
    return files


def _beside(
    given: WriterInput, package: str, description: "Description", semantics: "Semantics", driven: Driven
) -> dict[str, bytes]:
    """The files of MoveIt's package by path: none where the configuration wants none, or nothing moves."""
    from linkwright.stages.export.ros2.moveit import semantic_files, setup_assistant
    from linkwright.stages.export.ros2.moveit_launch import moveit_launch, moveit_rviz
    from linkwright.stages.export.ros2.names import moveit_package_of
    from linkwright.stages.export.ros2.package import MOVEIT, cmake_lists, package_xml
    from linkwright.stages.export.ros2.section import Ros2FormatSection

    name, keys = given.written.robot.name, given.keys.export.ros2 or Ros2FormatSection()
    if not keys.moveit or not semantics.groups:
        return {}
    own = moveit_package_of(package)
    texts = {
        "PACKAGE": own,
        "DESCRIPTION": package,
        "ROBOT": name,
        "ROOT": description.base,
        "WORLD": semantics.world,
        "CONTROLLED": repr(bool(driven.controllers)),
        "EXECUTES": repr(bool(driven.trajectories)),
        "PLUGIN": driven.control.plugin,
    }
    files = [
        *semantic_files(name, semantics, description, driven.trajectories),
        ("config/moveit.rviz", moveit_rviz(semantics.world or description.base, semantics.groups[0])),
        ("launch/moveit.launch.py", moveit_launch(texts)),
        (".setup_assistant", setup_assistant(name, package, keys.maintainer, keys.email)),
    ]
    what = f"MoveIt for the robot {name}: groups, poses, kinematics, limits, controllers and a launch file."
    files += [
        ("CMakeLists.txt", cmake_lists(own, [path for path, _ in files])),
        ("package.xml", package_xml(own, what, keys, [*MOVEIT, package])),
    ]
    return {f"{FOLDER}/{own}/{path}": data for path, data in files}


WRITER = Ros2Writer()
