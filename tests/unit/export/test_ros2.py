"""The ROS 2 package: its xacro expands to the robot of the plain URDF, and all that it names is there."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from linkwright.stages.export import export
from linkwright.stages.export.package_names import package_of
from linkwright.stages.export.ros2.names import legal_names, macro_of
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Frame, Limits, Relation, Robot, frozen
from linkwright.stages.robot.motion.start_pose import home
from tests.support.building import NO_MESHES, plan_of
from tests.support.engines import Pinocchio
from tests.support.robots import EVERY, at, joint, loop, pose, robot_with
from tests.support.ros2 import (
    Package,
    check_control,
    check_manifest,
    home_of,
    launched,
    packed,
    same_robot,
    same_text,
)
from tests.support.validators import check_urdf

TOLERANCE = 1e-9


def exported(robot: Robot, geometry: Geometry = NO_MESHES, **keys):
    keys = {"export": {"ros2": {}, "urdf": {}}} | keys
    return export(robot, geometry, plan_of(**keys))


def package(robot: Robot, folder: Path, geometry: Geometry = NO_MESHES, **keys) -> Package:
    return packed(exported(robot, geometry, **keys).files, folder)


def losses(robot: Robot, **keys) -> dict[str, str]:
    found = exported(robot, **keys).diagnostics
    return {one.code: one.message for one in found if one.where.startswith("ros2/")}


def every_kind() -> Robot:
    rng = np.random.default_rng(1)
    kinds = [kind for kind in EVERY if kind != "free"]
    limits = {"prismatic_link_joint": Limits(-0.1, 0.2)}
    rows = [joint(kind, "base", f"{kind}_link", place=pose(rng), limits=limits) for kind in kinds]
    rows.append(joint("revolute", "ball_link", "last", place=pose(rng)))
    return robot_with(
        rows,
        relations=[Relation("Gear", "last_joint", "revolute_link_joint", -2.0, 0.5)],
        frames=[Frame("tool", "last", frozen(at(0, 0, 0.1)), "Tool")],
    )


@pytest.mark.parametrize(
    ("arguments", "xyz"),
    [
        ({}, None),
        ({"use_ros2_control": "false"}, None),
        ({"prefix": "left_"}, None),
        ({"parent": "world", "xyz": "1 2 3", "rpy": "0 0 1.5"}, (1, 2, 3, 1.5)),
        ({"prefix": "r_", "parent": "table", "xyz": "0 0 1"}, (0, 0, 1, 0)),
    ],
)
def test_the_xacro_expands_to_the_robot_of_the_plain_urdf(arguments, xyz, tmp_path) -> None:
    robot = every_kind()
    files = exported(robot).files
    made = packed(files, tmp_path)
    shift = np.eye(4)
    if xyz:
        shift = at(*xyz[:3])
        shift[:2, :2] = [[math.cos(xyz[3]), -math.sin(xyz[3])], [math.sin(xyz[3]), math.cos(xyz[3])]]
    expanded = made.expanded(**arguments)
    prefix = arguments.get("prefix", "")
    same_robot(files["robot.urdf"], expanded, prefix, shift)
    same_text(made.plain, expanded, prefix)
    root = etree.fromstring(expanded)
    assert all(one.get("name").startswith(prefix) for one in root.findall("joint"))
    control = root.findall("ros2_control")
    assert len(control) == (arguments.get("use_ros2_control") != "false")
    tops = [one.get("name") for one in root.findall("link") if not one.get("name").startswith(prefix)]
    assert tops == ([arguments["parent"]] if prefix and "parent" in arguments else [])
    if not arguments:
        same_robot(files["robot.urdf"], made.plain)


def test_two_robots_in_one_file_share_no_name(tmp_path) -> None:
    made = package(every_kind(), tmp_path)
    macro = f"{made.folder}/urdf/robot"
    cell = tmp_path / "cell.xacro"
    cell.write_text(
        f"""<robot name="cell" xmlns:xacro="http://www.ros.org/wiki/xacro">
        <xacro:include filename="{macro}_macro.xacro"/><xacro:include filename="{macro}.ros2_control.xacro"/>
        <link name="world"/>
        <xacro:robot prefix="a_" parent="world"/><xacro:robot prefix="b_" parent="world" xyz="0 1 0"/>
        <xacro:robot_ros2_control prefix="a_"/><xacro:robot_ros2_control prefix="b_"/></robot>"""
    )
    xacro = pytest.importorskip("xacro")
    root = etree.fromstring(xacro.process_file(str(cell)).toxml().encode())
    for tag in ("link", "joint", "material", "ros2_control"):
        names = [one.get("name") for one in root.findall(tag)]
        assert len(set(names)) == len(names)
    assert len(root.findall("link")) == 1 + 2 * len(etree.fromstring(made.plain).findall("link"))


def test_the_manifest_follows_the_rules_and_has_what_the_keys_say(tmp_path) -> None:
    keys = {
        "package": "my_arm",
        "version": "1.2.3",
        "maintainer": "Ada <&>",
        "email": "ada@example.com",
        "license": "MIT",
    }
    made = package(every_kind(), tmp_path, export={"ros2": keys})
    assert made.name == "my_arm"
    needs = check_manifest(made)
    assert {"xacro", "rviz2", "robot_state_publisher", "controller_manager"} <= set(needs)
    root = etree.fromstring((made.folder / "package.xml").read_bytes())
    assert [root.findtext(key) for key in ("version", "maintainer", "license")] == ["1.2.3", "Ada <&>", "MIT"]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("package", "My_arm"),
        ("package", "my__arm"),
        ("package", "9arm"),
        ("package", "my-arm"),
        ("package", "a"),
        ("version", "1.0"),
        ("email", "nobody"),
    ],
)
def test_what_a_package_cannot_have_is_refused(key, value) -> None:
    from linkwright.pipeline.errors import ConfigError

    with pytest.raises(ConfigError, match=f"export.ros2.{key}"):
        plan_of(export={"ros2": {key: value}})


def test_a_root_called_world_is_its_own_parent_unless_it_has_a_prefix(tmp_path) -> None:
    made = package(robot_with([joint("revolute", "world", "arm", place=at(1, 0, 0))], root="world"), tmp_path)
    for prefix, mounts in (("", []), ("a_", ["a_world_mount"])):
        expanded = made.expanded(prefix=prefix, parent="world", xyz="0 0 2")
        root = etree.fromstring(expanded)
        names = [one.get("name") for one in root.findall("link")]
        assert names == [*(["world"] if prefix else []), f"{prefix}world", f"{prefix}arm"]
        assert [one.get("name") for one in root.findall("joint") if one.get("type") == "fixed"] == mounts
        pose = Pinocchio(expanded).poses({})[f"{prefix}arm"]
        assert np.abs(pose - at(1, 0, 2 if prefix else 0)).max() < TOLERANCE


def test_names_are_made_legal_and_what_changes_is_told(tmp_path) -> None:
    assert legal_names(["a b", "a_b", "1", "ü/x", "on"], "joint") == {
        "a b": "a_b_2",
        "a_b": "a_b",
        "1": "joint_1",
        "ü/x": "u_x",
        "on": "on",
    }
    assert package_of("9Bot--x") == "robot_9bot_x_description"
    assert [macro_of(one) for one in ("My-Arm", "if", "_")] == ["my_arm", "if_robot", "robot"]
    rows = [
        joint("revolute", "base", "my.arm", name="1"),
        joint("revolute", "my.arm", "yes", name="no", place=at(0, 0, 1)),
    ]
    frames = [Frame("tool tip", "yes", frozen(at(1, 2, 3)), "Tool")]
    robot = replace(robot_with(rows, frames=frames), name="If-9")
    keys = {"actuators": {"*": "position"}, "name": "If-9"}
    files = exported(robot, **keys).files
    made = packed(files, tmp_path)
    assert made.name == "if_9_description"
    said = losses(robot, **keys)["I-ROS2-NAME"]
    assert "link 'my.arm' is 'my_arm'" in said
    assert "link 'tool tip' is 'tool_tip'" in said
    assert "joint '1' is 'joint_1'" in said
    record = json.loads(files["robot.json"])["ros2"]
    assert record["package"] == "if_9_description"
    assert record["renamed"]["links"] == {"my.arm": "my_arm", "tool tip": "tool_tip"}
    assert record["renamed"]["joints"]["1"] == "joint_1"
    # YAML takes no and yes for truth values.
    (own,) = (one for name, one in made.controllers().items() if name == "joint_trajectory_controller")
    assert own["ros__parameters"]["joints"] == ["joint_1", "no"]
    read = Pinocchio(made.expanded())
    old = Pinocchio(files["If-9.urdf"])
    q = {"1": 0.3, "no": -0.4}
    found, expected = read.poses({"joint_1": 0.3, "no": -0.4}), old.poses(q)
    for name, own in {"my.arm": "my_arm", "tool tip": "tool_tip", "yes": "yes"}.items():
        assert np.abs(found[own] - expected[name]).max() < TOLERANCE


def driven() -> tuple[Robot, dict]:
    rows = [
        joint("revolute", "base", "one", limits={"one_joint": Limits(-1, 1)}),
        joint("prismatic", "one", "two", place=at(1, 0, 0)),
        joint("revolute", "two", "three", place=at(0, 1, 0)),
        joint("revolute", "three", "four"),
        joint("revolute", "four", "five"),
        joint("ball", "five", "six"),
        joint("revolute", "base", "seven", place=at(0, 0, 1)),
    ]
    robot = robot_with(
        rows,
        relations=[Relation("Gear", "four_joint", "one_joint", 2.0, 0.1)],
        frames=[Frame("eye", "six", frozen(at(0, 0, 0.2)), "Eye")],
    )
    keys = {
        "actuators": {
            "one_joint": "position",
            "two_joint": {"type": "velocity", "kv": 3},
            "three_joint": {"type": "motor", "force": True},
            "seven_joint": {"type": "damper", "kv": 1},
        },
        "keyframes": {"home": {"one_joint": 0.25}},
        "sensors": {
            "imu": {"type": "imu", "frame": "eye"},
            "wrist": {"type": "force_torque", "frame": "three"},
            "aside": {"type": "imu", "frame": "three", "xyz": [0, 0, 0.1]},
            "look": {"type": "camera", "frame": "eye"},
        },
    }
    return robot, keys


def test_interfaces_are_those_of_the_actuators_and_controllers_find_what_they_claim(tmp_path) -> None:
    robot, keys = driven()
    made = package(robot, tmp_path, **keys)
    check_control(made, made.expanded(), made.controllers())
    (control,) = etree.fromstring(made.expanded()).findall("ros2_control")

    def having(name: str, tag: str) -> list[str]:
        return [one.get("name") for one in control.find(f"joint[@name='{name}']").findall(tag)]

    commands = {
        one.get("name"): having(one.get("name"), "command_interface") for one in control.findall("joint")
    }
    assert {name: one for name, one in commands.items() if one} == {
        "one_joint": ["position"],
        "two_joint": ["velocity"],
        "three_joint": ["effort"],
        "seven_joint": ["effort"],
    }
    assert having("three_joint", "state_interface") == ["position", "velocity", "effort"]
    assert having("six_joint_x", "state_interface") == ["position", "velocity"]
    tree = made.controllers()
    own = {name: one["ros__parameters"] for name, one in tree.items()}
    assert own["velocity_controller"] == {"joints": ["two_joint"], "interface_name": "velocity"}
    assert own["effort_controller"] == {"joints": ["three_joint", "seven_joint"], "interface_name": "effort"}
    assert own["imu_broadcaster"] == {"sensor_name": "imu", "frame_id": "eye"}
    assert own["wrist_broadcaster"] == {"sensor_name": "wrist", "frame_id": "three"}
    # Mock hardware starts no controller of efforts where it works out motions.
    assert control.find("hardware/param[@name='calculate_dynamics']") is None
    said = losses(robot, **keys)
    assert "seven_joint (damper)" in said["I-ROS2-ACTUATOR"]
    assert said["I-ROS2-PASSIVE"].endswith(": five_joint, six_joint_x, six_joint_y, six_joint_z")
    assert "look" in said["I-ROS2-SENSOR"]
    assert "aside_gyro" in said["I-ROS2-SENSOR"]


def test_a_sensor_on_a_link_that_is_merged_has_no_frame_there(tmp_path) -> None:
    rows = [joint("revolute", "base", "arm"), joint("fixed", "arm", "plate", place=at(0, 0, 1))]
    frames = [Frame("eye", "plate", frozen(at(0, 0, 0.1)), "Eye")]
    robot = robot_with(rows, frames=frames)
    keys = {
        "export": {"ros2": {}, "urdf": {"fixed_joints": "merge"}},
        "sensors": {"lost": {"type": "imu", "frame": "plate"}, "kept": {"type": "imu", "frame": "eye"}},
        "attributes": {"arm": {"name": "limb", "formats": ["urdf"], "tag": "link"}},
    }
    made = package(robot, tmp_path, **keys)
    root = etree.fromstring(made.plain)
    assert {one.get("name") for one in root.findall("link")} == {"base", "limb", "eye"}
    own = made.controllers()
    assert own["kept_broadcaster"]["ros__parameters"]["frame_id"] == "eye"
    assert "lost_gyro" in losses(robot, **keys)["I-ROS2-SENSOR"]


@pytest.mark.parametrize(
    ("kind", "interface"),
    [
        ({"type": "position"}, "position"),
        ({"type": "intvelocity"}, "velocity"),
        ({"type": "velocity", "kv": 1}, "velocity"),
        ({"type": "motor"}, "effort"),
        ({"type": "general", "gainprm": [1]}, "effort"),
    ],
)
def test_each_type_of_actuator_has_its_interface(kind, interface, tmp_path) -> None:
    robot = robot_with([joint("revolute", "base", "arm")])
    made = package(robot, tmp_path, actuators={"*": kind})
    root = etree.fromstring(made.expanded())
    assert [one.get("name") for one in root.iter("command_interface")] == [interface]
    check_control(made, made.expanded(), made.controllers())


@pytest.mark.parametrize("multiplier", [-2.0, -406.88419829744066, 0.3047963227336805])
def test_a_joint_that_follows_another_has_no_command_even_if_it_has_an_actuator(multiplier, tmp_path) -> None:
    rows = [joint("revolute", "base", "one"), joint("revolute", "base", "two", place=at(0, 1, 0))]
    gear = Relation("Gear", "two_joint", "one_joint", multiplier, 0.0)
    robot = robot_with(rows, relations=[gear])
    keys = {"actuators": {"one_joint": "position", "two_joint": "position"}}
    made = package(robot, tmp_path, **keys)
    check_control(made, made.expanded(), made.controllers())
    assert losses(robot, **keys)["I-ROS2-FOLLOWER"].endswith(": two_joint")


def test_joints_start_at_home(tmp_path) -> None:
    robot, keys = driven()
    robot = replace(robot, keyframes=())
    saved = replace(
        robot, joints=tuple(replace(one, dofs=tuple(_moved(dof) for dof in one.dofs)) for one in robot.joints)
    )
    made = package(saved, tmp_path, **{key: keys[key] for key in ("actuators",)})
    start = home_of(made.expanded())
    at_home = home(saved)
    engine = Pinocchio(made.plain)
    found = engine.poses(start)
    expected = engine.poses(at_home)
    for link in found:
        assert np.abs(found[link] - expected[link]).max() < TOLERANCE


def _moved(dof):
    return replace(dof, saved=(0.8, 0.36, 0.48, 0.0) if dof.kind == "ball" else 0.1)


def test_what_looks_like_xacro_in_xml_of_the_users_own_stays_as_it_is(tmp_path) -> None:
    robot = robot_with([joint("revolute", "base", "arm")])
    xml = "<gazebo reference='arm' more='$(x)'><plugin name='${a}'>$(find b) ${c}</plugin></gazebo>"
    made = package(robot, tmp_path, elements={"more": {"into": {"tag": "robot"}, "xml": xml}})
    for prefix in ("", "left_"):
        same_text(made.plain, made.expanded(prefix=prefix), prefix)


def test_speeds_move_mock_hardware_where_nothing_is_commanded_by_effort(tmp_path) -> None:
    robot = robot_with([joint("revolute", "base", "wheel")])
    made = package(robot, tmp_path, actuators={"*": {"type": "velocity", "kv": 1}})
    (control,) = etree.fromstring(made.expanded()).findall("ros2_control")
    assert control.findtext("hardware/param[@name='calculate_dynamics']") == "true"
    assert control.findtext("hardware/plugin") == "mock_components/GenericSystem"


def test_the_hardware_of_the_source_is_that_without_mock_hardware(tmp_path) -> None:
    xacro = pytest.importorskip("xacro")
    text = (
        '<ros2_control name="x" type="system"><hardware><plugin>mine/Arm</plugin>'
        '<param name="port">${a}</param></hardware>'
        '<joint name="arm_joint"><param name="can_id">7</param><param name="mimic">x</param>'
        '<command_interface name="effort"><param name="min">-2.5</param><param name="max">3</param>'
        "</command_interface></joint></ros2_control>"
    )
    robot = replace(robot_with([joint("revolute", "base", "arm")]), controls=(text,))
    made = package(robot, tmp_path)
    expanded = made.expanded(use_mock_hardware="false")
    check_control(made, expanded, made.controllers(), parameters={"arm_joint": {"can_id": "7"}})
    (control,) = etree.fromstring(expanded).findall("ros2_control")
    assert control.findtext("hardware/plugin") == "mine/Arm"
    assert control.findtext("hardware/param[@name='port']") == "${a}"
    assert [(one.get("name"), one.text) for one in control.findall("joint/param")] == [("can_id", "7")]
    limits = control.findall("joint/command_interface[@name='effort']/param")
    assert [(one.get("name"), one.text) for one in limits] == [("min", "-2.5"), ("max", "3")]
    assert made.controllers()["effort_controller"]["ros__parameters"]["joints"] == ["arm_joint"]
    assert "I-ROS2-CONTROL" in losses(robot)
    other = made.expanded(use_mock_hardware="false", hardware_plugin="his/Arm")
    assert etree.fromstring(other).findtext("ros2_control/hardware/plugin") == "his/Arm"
    none = package(robot_with([joint("revolute", "base", "arm")]), tmp_path / "none")
    with pytest.raises(xacro.XacroException, match="hardware_plugin"):
        none.expanded(use_mock_hardware="false")


def test_launch_files_start_nodes_of_packages_that_the_manifest_names(tmp_path, monkeypatch) -> None:
    robot, keys = driven()
    made = package(robot, tmp_path, **keys)
    state, sliders, rviz = launched(made, "display.launch.py", monkeypatch)
    assert state.parameters[0]["robot_description"].value.encode() == made.expanded()
    assert state.parameters[0]["robot_description"].value_type is str
    assert sliders.package == "joint_state_publisher_gui"
    (zeros,) = sliders.parameters
    assert zeros["zeros"]["two_joint"] == 0.0
    assert "four_joint" not in zeros["zeros"]
    assert rviz.arguments[-1] == "base"
    nodes = launched(made, "display.launch.py", monkeypatch, gui="false", rviz="false", prefix="l_")
    assert [one.package for one in nodes] == ["robot_state_publisher", "joint_state_publisher"]
    assert set(nodes[1].parameters[0]["zeros"]) == {f"l_{name}" for name in zeros["zeros"]}
    for prefix in ("", "l_"):
        state, manager, *spawners = launched(made, "control.launch.py", monkeypatch, prefix=prefix)
        assert manager.executable == "ros2_control_node"
        urdf = state.parameters[0]["robot_description"].value.encode()
        tree = made.controllers()
        if prefix:
            import yaml

            tree = yaml.safe_load(Path(manager.parameters[0]).read_text())
        else:
            assert manager.parameters == [str(made.folder / "config" / "controllers.yaml")]
        check_control(made, urdf, tree, prefix)
        known = set(tree["controller_manager"]["ros__parameters"]) - {"update_rate"}
        assert {one.arguments[0] for one in spawners} == known
        assert all(one.executable == "spawner" for one in spawners)


def painted() -> tuple[Robot, Geometry]:
    robot = robot_with([joint("revolute", "base", "arm")])
    shapes = (
        Shape("base", "visual", "base.obj", (1.0, 0.0, 0.0, 1.0), 3, 1, 1.0, 0.0),
        Shape("arm", "visual", "arm.obj", (1.0, 1.0, 1.0, 1.0), 3, 1, 1.0, 0.0, texture="wood.png"),
    )
    triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n# "
    names = ("base.obj", "arm.obj", "arm.mtl", "wood.png")
    return robot, Geometry(shapes, {name: f"{triangle}{name}".encode() for name in names})


def test_every_path_of_a_mesh_or_texture_exists_and_rviz_shows_the_root(tmp_path) -> None:
    robot, geometry = painted()
    files = geometry.files
    for meshes in ("relative", "package"):
        made = package(robot, tmp_path / meshes, geometry, export={"ros2": {}, "urdf": {"meshes": meshes}})
        for urdf in (made.plain, made.expanded()):
            same_text(made.plain, made.expanded(prefix="left_"), "left_")
            root = etree.fromstring(urdf)
            uris = [one.get("filename") for one in root.iter("mesh", "texture")]
            assert len(uris) == 3
            assert all(made.file_of(uri).read_bytes() == files[made.file_of(uri).name] for uri in uris)
        assert sorted(one.name for one in (made.folder / "meshes").iterdir()) == sorted(files)
        import yaml

        shown = yaml.safe_load((made.folder / "rviz" / "robot.rviz").read_text())["Visualization Manager"]
        assert shown["Global Options"]["Fixed Frame"] == "base"
        classes = [one["Class"] for one in shown["Displays"]]
        assert "rviz_default_plugins/RobotModel" in classes


def test_the_users_own_xml_is_in_the_package_also_without_the_urdf(tmp_path) -> None:
    robot = robot_with([joint("revolute", "base", "arm")])
    keys = {
        "elements": {
            "more": {"into": {"tag": "robot"}, "formats": ["urdf"], "xml": "<gazebo reference='arm'/>"}
        }
    }
    result = exported(robot, export={"ros2": {}}, **keys)
    assert "robot.urdf" not in result.files
    made = packed(result.files, tmp_path)
    assert etree.fromstring(made.plain).find("gazebo").get("reference") == "arm"
    expanded = etree.fromstring(made.expanded(prefix="p_"))
    assert expanded.find("gazebo").get("reference") == "p_arm"
    # What the URDF cannot say is told for the package.
    assert "I-URDF-UNSET" in {one.code for one in result.diagnostics}


def test_a_loop_leaves_its_joints_without_command_and_a_robot_without_joints_has_no_control(tmp_path) -> None:
    rows = [
        joint("revolute", "base", "one"),
        joint("revolute", "one", "two", place=at(1, 0, 0)),
        joint("revolute", "base", "three", place=at(0, 2, 0)),
    ]
    shut = loop("revolute", "two", "three", at(0, 2, 0), at(1, 0, 0), [0.0])
    robot = robot_with(rows, loops=[shut])
    keys = {"actuators": {"one_joint": "position"}}
    made = package(robot, tmp_path, **keys)
    check_control(made, made.expanded(), made.controllers())
    trajectory = made.controllers()["joint_trajectory_controller"]["ros__parameters"]
    assert trajectory["joints"] == ["one_joint"]
    stiff = package(robot_with([joint("fixed", "base", "arm")]), tmp_path / "stiff")
    assert etree.fromstring(stiff.expanded()).find("ros2_control") is None
    assert not (stiff.folder / "config").exists()
    assert "controller_manager" not in check_manifest(stiff)


def test_urdfdom_accepts_what_is_expanded(tmp_path) -> None:
    made = package(every_kind(), tmp_path)
    for prefix in ("", "left_"):
        path = tmp_path / "robot.urdf"
        path.write_bytes(made.expanded(prefix=prefix, parent="table"))
        assert check_urdf(path) == ""
