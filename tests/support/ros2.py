"""A ROS 2 package as ROS would take it, without ROS: its xacro expanded, its launch files run, its
package.xml read.

The launch files run against stand-ins of `launch`, `launch_ros` and `ament_index_python`, made up after their
documentation: they record what is started and know nothing else.
"""

import re
import runpy
import sys
from dataclasses import dataclass, field, make_dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import yaml
from lxml import etree

from tests.support.engines import Pinocchio

TOLERANCE = 1e-9

TAGS = (
    "name|version|description|maintainer|license|url|author|export|build_depend|build_export_depend|depend|"
    "buildtool_depend|buildtool_export_depend|exec_depend|doc_depend|test_depend|conflict|replace|"
    "group_depend|member_of_group"
)
"""The elements of a package.xml, of REP 149."""

EXECUTABLES = {
    "robot_state_publisher": {"robot_state_publisher"},
    "joint_state_publisher": {"joint_state_publisher"},
    "joint_state_publisher_gui": {"joint_state_publisher_gui"},
    "rviz2": {"rviz2"},
    "controller_manager": {"ros2_control_node", "spawner"},
    "moveit_ros_move_group": {"move_group"},
    "tf2_ros": {"static_transform_publisher"},
}
"""Package → the programs of it that there are."""

MOVEIT = "*_moveit_config"

CONTROLLERS = {
    "joint_state_broadcaster/JointStateBroadcaster",
    "joint_trajectory_controller/JointTrajectoryController",
    "forward_command_controller/ForwardCommandController",
    "imu_sensor_broadcaster/IMUSensorBroadcaster",
    "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster",
}
"""Controllers that ros2_controllers has."""


BROADCAST = {
    "imu_sensor_broadcaster": {
        "orientation": "xyzw",
        "angular_velocity": "xyz",
        "linear_acceleration": "xyz",
    },
    "force_torque_sensor_broadcaster": {"force": "xyz", "torque": "xyz"},
}
"""The quantities that each broadcaster of a sensor claims, and their axes."""


@dataclass
class Package:
    """A package in a folder of its name."""

    folder: Path

    @property
    def name(self):
        return self.folder.name

    @property
    def entry(self):
        (path,) = (self.folder / "urdf").glob("*.urdf.xacro")
        return path

    @property
    def plain(self):
        (path,) = (self.folder / "urdf").glob("*.urdf")
        return path.read_bytes()

    def expanded(self, **arguments):
        """The URDF that xacro makes."""
        xacro = pytest.importorskip("xacro")
        return xacro.process_file(str(self.entry), mappings=arguments).toxml().encode()

    def controllers(self):
        path = self.folder / "config" / "controllers.yaml"
        return yaml.safe_load(path.read_text()) if path.exists() else {}

    def file_of(self, uri):
        """What `package://` stands for."""
        name, _, path = uri.removeprefix("package://").partition("/")
        assert uri.startswith("package://"), uri
        assert name == self.name
        return self.folder / path


def packed(files, folder):
    """The robot's package among the files of a build, written below a folder."""
    package_files = {path: data for path, data in files.items() if path.startswith("ros2/")}
    for path, data in package_files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)
    return package_in(folder)


def package_in(output):
    """The robot's package in the output of a build."""
    (manifest,) = [path for path in (output / "ros2").glob("*/package.xml") if not path.parent.match(MOVEIT)]
    return Package(manifest.parent)


def moveit_of(package):
    """The package of MoveIt beside another one."""
    folders = [path for path in package.folder.parent.iterdir() if path.match(MOVEIT)]
    return Package(folders[0]) if folders else None


def check_manifest(package):
    """What the rules of package.xml (REP 149 and 144) demand; returns what the package runs with."""
    root = etree.fromstring((package.folder / "package.xml").read_bytes())
    assert (root.tag, root.get("format")) == ("package", "3")
    tags = [element.tag for element in root]
    assert all(re.fullmatch(TAGS, tag) for tag in tags)
    for required in ("name", "version", "description", "maintainer", "license"):
        assert tags.count(required) >= 1
        assert all((element.text or "").strip() for element in root.findall(required))
    assert all(tags.count(tag) == 1 for tag in ("name", "version", "description", "export"))
    assert root.findtext("name") == package.name
    assert re.fullmatch("[a-z][a-z0-9]*(_[a-z0-9]+)*", package.name)
    assert re.fullmatch(r"\d+\.\d+\.\d+", root.findtext("version"))
    assert all("@" in maintainer.get("email") for maintainer in root.findall("maintainer"))
    assert root.findtext("export/build_type") == "ament_cmake"
    assert "ament_cmake" in [buildtool_depend.text for buildtool_depend in root.findall("buildtool_depend")]
    needs = [exec_depend.text for exec_depend in root.findall("exec_depend")]
    assert len(set(needs)) == len(needs)
    cmake = (package.folder / "CMakeLists.txt").read_text()
    assert re.search(rf"^project\({package.name}\)$", cmake, re.MULTILINE)
    (folders,) = re.findall(r"DIRECTORY (.*)\n", cmake)
    assert sorted(folders.split()) == sorted(path.name for path in package.folder.iterdir() if path.is_dir())
    return needs


def imagined(name, *fields):
    """A stand-in of a class of ROS, which records its arguments."""
    return make_dataclass(name, fields)


@dataclass
class Node:
    """Imagined: a node that a launch file starts."""

    package: str
    executable: str
    parameters: list = field(default_factory=list)
    arguments: list = field(default_factory=list)
    remappings: list = field(default_factory=list)
    output: str = "log"


DeclareLaunchArgument = imagined("DeclareLaunchArgument", "name", "default_value", "description")
OpaqueFunction = imagined("OpaqueFunction", "function")
LaunchDescription = imagined("LaunchDescription", "entities")
ParameterValue = imagined("ParameterValue", "value", "value_type")
PythonLaunchDescriptionSource = imagined("PythonLaunchDescriptionSource", "path")
IncludeLaunchDescription = imagined("IncludeLaunchDescription", "source", "launch_arguments")


@dataclass
class LaunchConfiguration:
    """Imagined: an argument, performed against the values of all."""

    name: str

    def perform(self, context):
        return context[self.name]


PARTS = (
    "robot_description", "robot_description_semantic", "robot_description_kinematics", "planning_pipelines",
    "trajectory_execution", "joint_limits", "pilz_cartesian_limits",
)  # fmt: skip


class MoveItConfigs:
    """Imagined: what MoveIt's builder has read."""

    def __init__(self):
        vars(self).update({part: {} for part in PARTS})

    def to_dict(self):
        return {key: value for part in vars(self).values() for key, value in part.items()}


def builder_of(share):
    """Imagined: `MoveItConfigsBuilder`, which finds files in a package by the names that it documents."""

    class MoveItConfigsBuilder:
        def __init__(self, robot_name, package_name):
            self.folder, self.made = Path(share(package_name)), MoveItConfigs()
            self.config = yaml.safe_load((self.folder / ".setup_assistant").read_text())[
                "moveit_setup_assistant_config"
            ]

        def robot_description(self, mappings):
            place = self.config["urdf"]
            path = Path(share(place["package"])) / place["relative_path"]
            text = pytest.importorskip("xacro").process_file(str(path), mappings=dict(mappings)).toxml()
            self.made.robot_description = {"robot_description": text}
            return self

        def planning_pipelines(self, pipelines):
            self.made.planning_pipelines = {"planning_pipelines": pipelines}
            return self

        def to_moveit_configs(self):
            path = self.folder / self.config["srdf"]["relative_path"]
            # It takes the SRDF for a xacro, too.
            text = pytest.importorskip("xacro").process_file(str(path)).toxml()
            self.made.robot_description_semantic = {"robot_description_semantic": text}
            for part, key, file in (
                ("robot_description_kinematics", "robot_description_kinematics", "kinematics"),
                ("joint_limits", "robot_description_planning", "joint_limits"),
                ("pilz_cartesian_limits", "robot_description_planning", "pilz_cartesian_limits"),
            ):
                setattr(self.made, part, {key: self._read(file)})
            files = list((self.folder / "config").glob("*_controllers.yaml"))
            if files:
                (own,) = files
                self.made.trajectory_execution = self._read(own.stem)
            return self.made

        def _read(self, name):
            return yaml.safe_load((self.folder / "config" / f"{name}.yaml").read_text())

    return MoveItConfigsBuilder


def launched(package, file, monkeypatch, **chosen):
    """What a launch file starts, every argument not given at its default: nodes, and other launch files."""

    def share(name):
        folder = package.folder.parent / name
        assert (folder / "package.xml").is_file()
        assert name == package.name or name in check_manifest(package)
        return str(folder)

    modules = {
        "launch": {"LaunchDescription": LaunchDescription},
        "launch.actions": {
            "DeclareLaunchArgument": DeclareLaunchArgument,
            "OpaqueFunction": OpaqueFunction,
            "IncludeLaunchDescription": IncludeLaunchDescription,
        },
        "launch.launch_description_sources": {"PythonLaunchDescriptionSource": PythonLaunchDescriptionSource},
        "moveit_configs_utils": {"MoveItConfigsBuilder": builder_of(share)},
        "launch.substitutions": {"LaunchConfiguration": LaunchConfiguration},
        "launch_ros": {},
        "launch_ros.actions": {"Node": Node},
        "launch_ros.parameter_descriptions": {"ParameterValue": ParameterValue},
        "ament_index_python": {},
        "ament_index_python.packages": {"get_package_share_directory": share},
    }
    pytest.importorskip("xacro")
    for name, contents in modules.items():
        module = ModuleType(name)
        vars(module).update(contents)
        monkeypatch.setitem(sys.modules, name, module)
    made = runpy.run_path(str(package.folder / "launch" / file))["generate_launch_description"]()
    arguments = {
        argument.name: argument for argument in made.entities if isinstance(argument, DeclareLaunchArgument)
    }
    assert set(chosen) <= set(arguments)
    assert all(argument.description for argument in arguments.values())
    values = {name: argument.default_value for name, argument in arguments.items()} | chosen
    nodes = []
    for entity in made.entities:
        if isinstance(entity, OpaqueFunction):
            nodes += entity.function(values)
    needs = check_manifest(package)
    for node in nodes:
        if isinstance(node, IncludeLaunchDescription):
            assert Path(node.source.path).is_file()
            continue
        assert node.executable in EXECUTABLES[node.package]
        assert node.package in needs
        for text in node.arguments:
            assert not text.startswith("/") or text == "/controller_manager" or Path(text).is_file(), text
    return nodes


def check_control(package, urdf, controllers, prefix="", parameters=None):
    """Every joint of the <ros2_control> moves in the URDF, those that follow another are not commanded, and
    every controller finds the interfaces that it claims. `parameters`: of joints, as their source has them.
    """
    root = etree.fromstring(urdf)
    joints = {element.get("name"): element for element in root.findall("joint")}
    links = {link.get("name") for link in root.findall("link")}
    (control,) = root.findall("ros2_control")
    assert control.get("type") == "system"
    plugins = [plugin.text for plugin in control.findall("hardware/plugin")]
    assert len(plugins) == 1
    assert "/" in plugins[0]
    commands, states = set(), set()
    names = [element.get("name") for element in control if element.tag in ("joint", "sensor")]
    assert len(set(names)) == len(names)
    types = ("revolute", "continuous", "prismatic")
    moving = [name for name, element in joints.items() if element.get("type") in types]
    assert [element.get("name") for element in control.findall("joint")] == moving
    for node in control.findall("joint"):
        name = node.get("name")
        mimic = joints[name].find("mimic")
        params = {param.get("name"): param.text for param in node.findall("param")}
        if mimic is not None:
            assert not node.findall("command_interface")
            assert params["mimic"] == mimic.get("joint")
            assert float(params["multiplier"]) == float(mimic.get("multiplier"))
            assert mimic.get("joint") in names
        else:
            assert params == (parameters or {}).get(name, {})
        commands |= {(name, interface.get("name")) for interface in node.findall("command_interface")}
        states |= {(name, interface.get("name")) for interface in node.findall("state_interface")}
    for node in control.findall("sensor"):
        states |= {(node.get("name"), interface.get("name")) for interface in node.findall("state_interface")}
        assert node.findtext("param[@name='frame_id']") in links
    claimed = []
    manager = dict(controllers["controller_manager"]["ros__parameters"])
    assert manager.pop("update_rate") > 0
    assert set(controllers) - {"controller_manager"} <= set(manager)
    for name, about in manager.items():
        assert about["type"] in CONTROLLERS
        kind = about["type"].partition("/")[0]
        assert kind in check_manifest(package)
        own = controllers.get(name, {}).get("ros__parameters", {})
        if kind == "joint_state_broadcaster":
            assert own == {}
        elif kind == "joint_trajectory_controller":
            for joint in own["joints"]:
                claimed += [(joint, interface) for interface in own["command_interfaces"]]
                assert {(joint, interface) for interface in own["state_interfaces"]} <= states
        elif kind == "forward_command_controller":
            claimed += [(joint, own["interface_name"]) for joint in own["joints"]]
        else:
            assert own["frame_id"] in links
            assert own["frame_id"].startswith(prefix)
            interfaces = {interface for sensor, interface in states if sensor == own["sensor_name"]}
            quantities = BROADCAST[kind].items()
            assert interfaces == {f"{quantity}.{axis}" for quantity, axes in quantities for axis in axes}
    assert len(set(claimed)) == len(claimed), "two controllers claim one interface"
    assert set(claimed) <= commands
    # Each joint that can be commanded is commanded by some controller.
    assert {joint for joint, _ in claimed} == {joint for joint, _ in commands}


def home_of(urdf):
    """Where the joints of a <ros2_control> start [rad or m]."""
    path = "state_interface[@name='position']/param[@name='initial_value']"
    joints = etree.fromstring(urdf).findall("ros2_control/joint")
    return {joint.get("name"): float(joint.findtext(path)) for joint in joints}


def same_robot(ours, theirs, prefix="", shift=None):
    """Poses, mass matrix and limits of two URDFs in Pinocchio at drawn values of the joints: in `theirs` the
    names have a prefix, and the root link is at `shift` (4, 4)."""
    first, other = Pinocchio(ours), Pinocchio(theirs)
    shift = np.eye(4) if shift is None else shift
    names = [name for name in first.model.names if name != "universe"]
    assert sorted(prefix + name for name in names) == sorted(n for n in other.model.names if n != "universe")
    ids = [(first.model.getJointId(name), other.model.getJointId(prefix + name)) for name in names]
    single = [name for name, (index, _) in zip(names, ids, strict=True) if first.model.joints[index].nv == 1]
    rng = np.random.default_rng(0)
    for _ in range(3):
        q = {name: float(rng.uniform(-1.5, 1.5)) for name in single}
        moved = {prefix + name: value for name, value in q.items()}
        placed, expected = other.poses(moved), first.poses(q)
        for link in set(expected) - {"world"}:
            assert np.abs(placed[prefix + link] - shift @ expected[link]).max() < TOLERANCE, link
        if single:
            mass = other.mass_matrix(moved, [prefix + name for name in single])
            scale = max(1.0, np.abs(mass).max())
            assert np.abs(mass - first.mass_matrix(q, single)).max() < TOLERANCE * scale
    for own, its in ids:
        first_model, yours = first.model.joints[own], other.model.joints[its]
        for end in ("lowerPositionLimit", "upperPositionLimit"):
            ends = getattr(first.model, end)[first_model.idx_q], getattr(other.model, end)[yours.idx_q]
            assert ends[0] == ends[1], own
        for most in ("velocityLimit", "effortLimit"):
            if hasattr(first.model, most):
                values = getattr(first.model, most), getattr(other.model, most)
                assert values[0][first_model.idx_v] == values[1][yours.idx_v], own


def same_text(plain, expanded, prefix=""):
    """Every element of a URDF is in the other, in the same order, with a prefix before names; the rest of the
    other is what mounts the robot and its ros2_control."""
    first, second = (etree.fromstring(text) for text in (plain, expanded))
    kinds = ("link", "joint", "material", "transmission", "actuator")
    named = {element.get("name") for element in first.iter(*kinds)}
    for node in first.iter(tag="*"):
        for key in ("name", "link", "joint", "reference"):
            if node.get(key) in named:
                node.set(key, prefix + node.get(key))
    ours = [_canonical(element) for element in first.iterchildren(tag="*") if element.tag != "ros2_control"]
    theirs = [_canonical(element) for element in second.iterchildren(tag="*")]
    more = [their for their in theirs if their not in set(ours)]
    assert [their for their in theirs if their not in set(more)] == ours
    assert len([text for text in more if not text.startswith("<ros2_control")]) in (0, 2)


def _canonical(node):
    return etree.canonicalize(etree.tostring(node).decode(), strip_text=True)
