"""The ROS 2 package: its xacro expands to the robot of the plain URDF, and all that it names is there."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from lxml import etree

from linkwright.stages.export.package_names import package_of
from linkwright.stages.export.ros2.names import legal_names, macro_of
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Frame, Limits, Relation, frozen
from linkwright.stages.robot.motion.start_pose import home
from tests.support.building import NO_MESHES
from tests.support.engines import Pinocchio
from tests.support.exports import exported, losses_of, messages_of
from tests.support.robots import EVERY, at, joint, loop, pose, robot_with
from tests.support.ros2 import check_control, check_manifest, home_of, launched, packed, same_robot, same_text
from tests.support.validators import check_urdf

TOLERANCE = 1e-9


def ros2_export(robot, geometry=NO_MESHES, **keys):
    keys = {"export": {"ros2": {}, "urdf": {}}} | keys
    return exported(robot, geometry, **keys)


def package(robot, folder, geometry=NO_MESHES, **keys):
    return packed(ros2_export(robot, geometry, **keys).files, folder)


def losses(robot, **keys):
    return losses_of(ros2_export(robot, **keys), "ros2/")


def names(root, tag):
    return [element.get("name") for element in root.findall(tag)]


def checked_control(made):
    """The <ros2_control> of the expanded xacro, which the controllers fit."""
    expanded = made.expanded()
    check_control(made, expanded, made.controllers())
    (control,) = etree.fromstring(expanded).findall("ros2_control")
    return control


def parameters_of(made):
    """The parameters of each controller."""
    return {name: value["ros__parameters"] for name, value in made.controllers().items()}


def every_kind():
    rng = np.random.default_rng(1)
    kinds = [kind for kind in EVERY if kind != "free"]
    limits = {"prismatic_link_joint": Limits(-0.1, 0.2)}
    rows = [joint(kind, "base", f"{kind}_link", place=pose(rng), limits=limits) for kind in kinds]
    rows.append(joint("revolute", "ball_link", "last", place=pose(rng)))
    gear = Relation("Gear", "last_joint", "revolute_link_joint", -2.0, 0.5)
    return robot_with(rows, relations=[gear], frames=[Frame("tool", "last", frozen(at(0, 0, 0.1)), "Tool")])


@pytest.mark.parametrize(("arguments", "xyz", "yaw"), [
    ({}, (0, 0, 0), 0.0),
    ({"use_ros2_control": "false"}, (0, 0, 0), 0.0),
    ({"prefix": "left_"}, (0, 0, 0), 0.0),
    ({"parent": "world", "xyz": "1 2 3", "rpy": "0 0 1.5"}, (1, 2, 3), 1.5),
    ({"prefix": "r_", "parent": "table", "xyz": "0 0 1"}, (0, 0, 1), 0.0),
])  # fmt: skip
def test_xacro_expands_to_the_robot_of_the_plain_urdf(arguments, xyz, yaw, tmp_path):
    files = ros2_export(every_kind()).files
    made = packed(files, tmp_path)
    expanded, prefix = made.expanded(**arguments), arguments.get("prefix", "")
    shift = at(*xyz) @ from_parts(rotation_from_rpy((0.0, 0.0, yaw)), np.zeros(3))
    same_robot(files["robot.urdf"], expanded, prefix, shift)
    same_text(made.plain, expanded, prefix)
    root = etree.fromstring(expanded)
    assert all(name.startswith(prefix) for name in names(root, "joint"))
    assert len(root.findall("ros2_control")) == (arguments.get("use_ros2_control") != "false")
    tops = [name for name in names(root, "link") if not name.startswith(prefix)]
    assert tops == ([arguments["parent"]] if prefix and "parent" in arguments else [])
    if not arguments:
        same_robot(files["robot.urdf"], made.plain)


def test_two_robots_in_one_file_share_no_name(tmp_path):
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
        assert len(set(names(root, tag))) == len(names(root, tag))
    assert len(root.findall("link")) == 1 + 2 * len(etree.fromstring(made.plain).findall("link"))


def test_manifest_follows_the_rules_and_the_keys(tmp_path):
    keys = {
        "package": "my_arm", "version": "1.2.3", "maintainer": "Ada <&>", "email": "ada@example.com",
        "license": "MIT",
    }  # fmt: skip
    made = package(every_kind(), tmp_path, export={"ros2": keys})
    assert made.name == "my_arm"
    needs = check_manifest(made)
    assert {"xacro", "rviz2", "robot_state_publisher", "controller_manager"} <= set(needs)
    root = etree.fromstring((made.folder / "package.xml").read_bytes())
    assert [root.findtext(key) for key in ("version", "maintainer", "license")] == ["1.2.3", "Ada <&>", "MIT"]


@pytest.mark.parametrize(("prefix", "above", "mounts"), [("", [], []), ("a_", ["world"], ["a_world_mount"])])
def test_root_called_world_is_its_own_parent_without_prefix(prefix, above, mounts, tmp_path):
    made = package(robot_with([joint("revolute", "world", "arm", place=at(1, 0, 0))], root="world"), tmp_path)
    expanded = made.expanded(prefix=prefix, parent="world", xyz="0 0 2")
    root = etree.fromstring(expanded)
    assert names(root, "link") == [*above, f"{prefix}world", f"{prefix}arm"]
    assert names(root, "joint[@type='fixed']") == mounts
    placed = Pinocchio(expanded).poses({})[f"{prefix}arm"]
    assert np.abs(placed - at(1, 0, 2 if prefix else 0)).max() < TOLERANCE


def test_names_become_legal_by_fixed_rules():
    legal = {"a b": "a_b_2", "a_b": "a_b", "1": "joint_1", "ü/x": "u_x", "on": "on"}
    assert legal_names([*legal], "joint") == legal
    assert package_of("9Bot--x") == "robot_9bot_x_description"
    assert [macro_of(name) for name in ("My-Arm", "if", "_")] == ["my_arm", "if_robot", "robot"]


def test_names_that_change_are_told(tmp_path):
    rows = [
        joint("revolute", "base", "my.arm", name="1"),
        joint("revolute", "my.arm", "yes", name="no", place=at(0, 0, 1)),
    ]
    robot = robot_with(rows, frames=[Frame("tool tip", "yes", frozen(at(1, 2, 3)), "Tool")], name="If-9")
    keys = {"actuators": {"*": "position"}, "name": "If-9"}
    files = ros2_export(robot, **keys).files
    made = packed(files, tmp_path)
    said = losses(robot, **keys)["I-ROS2-NAME"]
    for text in ("link 'my.arm' is 'my_arm'", "link 'tool tip' is 'tool_tip'", "joint '1' is 'joint_1'"):
        assert text in said
    record = json.loads(files["robot.json"])["ros2"]
    assert made.name == record["package"] == "if_9_description"
    assert record["renamed"]["links"] == {"my.arm": "my_arm", "tool tip": "tool_tip"}
    assert record["renamed"]["joints"]["1"] == "joint_1"
    # YAML takes no and yes for truth values.
    assert parameters_of(made)["joint_trajectory_controller"]["joints"] == ["joint_1", "no"]
    actual = Pinocchio(made.expanded()).poses({"joint_1": 0.3, "no": -0.4})
    expected = Pinocchio(files["If-9.urdf"]).poses({"1": 0.3, "no": -0.4})
    for name, renamed in {"my.arm": "my_arm", "tool tip": "tool_tip", "yes": "yes"}.items():
        assert np.abs(actual[renamed] - expected[name]).max() < TOLERANCE


def driven():
    rows = [
        joint("revolute", "base", "one", limits={"one_joint": Limits(-1, 1)}),
        joint("prismatic", "one", "two", place=at(1, 0, 0)),
        joint("revolute", "two", "three", place=at(0, 1, 0)), joint("revolute", "three", "four"),
        joint("revolute", "four", "five"), joint("ball", "five", "six"),
        joint("revolute", "base", "seven", place=at(0, 0, 1)),
    ]  # fmt: skip
    robot = robot_with(
        rows,
        relations=[Relation("Gear", "four_joint", "one_joint", 2.0, 0.1)],
        frames=[Frame("eye", "six", frozen(at(0, 0, 0.2)), "Eye")],
    )
    keys = {
        "actuators": {
            "one_joint": "position", "two_joint": {"type": "velocity", "kv": 3},
            "three_joint": {"type": "motor", "force": True}, "seven_joint": {"type": "damper", "kv": 1},
        },
        "keyframes": {"home": {"one_joint": 0.25}},
        "sensors": {
            "imu": {"type": "imu", "frame": "eye"}, "wrist": {"type": "force_torque", "frame": "three"},
            "aside": {"type": "imu", "frame": "three", "xyz": [0, 0, 0.1]},
            "look": {"type": "camera", "frame": "eye"},
        },
    }  # fmt: skip
    return robot, keys


def test_interfaces_are_those_of_the_actuators(tmp_path):
    robot, keys = driven()
    made = package(robot, tmp_path, **keys)
    control = checked_control(made)
    joints = {node.get("name"): node for node in control.findall("joint")}
    commands = {name: names(node, "command_interface") for name, node in joints.items()}
    assert {name: command for name, command in commands.items() if command} == {
        "one_joint": ["position"], "two_joint": ["velocity"], "three_joint": ["effort"],
        "seven_joint": ["effort"],
    }  # fmt: skip
    assert names(joints["three_joint"], "state_interface") == ["position", "velocity", "effort"]
    assert names(joints["six_joint_x"], "state_interface") == ["position", "velocity"]
    efforts = {"joints": ["three_joint", "seven_joint"], "interface_name": "effort"}
    expected = {
        "velocity_controller": {"joints": ["two_joint"], "interface_name": "velocity"},
        "effort_controller": efforts,
        "imu_broadcaster": {"sensor_name": "imu", "frame_id": "eye"},
        "wrist_broadcaster": {"sensor_name": "wrist", "frame_id": "three"},
    }
    assert {name: parameters_of(made)[name] for name in expected} == expected
    # Mock hardware starts no controller of efforts where it works out motions.
    assert control.find("hardware/param[@name='calculate_dynamics']") is None
    said = losses(robot, **keys)
    assert "seven_joint (damper)" in said["I-ROS2-ACTUATOR"]
    assert said["I-ROS2-PASSIVE"].endswith(": five_joint, six_joint_x, six_joint_y, six_joint_z")
    assert "look" in said["I-ROS2-SENSOR"]
    assert "aside_gyro" in said["I-ROS2-SENSOR"]


def test_sensor_on_a_link_that_is_merged_has_no_frame_there(tmp_path):
    rows = [joint("revolute", "base", "arm"), joint("fixed", "arm", "plate", place=at(0, 0, 1))]
    robot = robot_with(rows, frames=[Frame("eye", "plate", frozen(at(0, 0, 0.1)), "Eye")])
    keys = {
        "export": {"ros2": {}, "urdf": {"fixed_joints": "merge"}},
        "sensors": {"lost": {"type": "imu", "frame": "plate"}, "kept": {"type": "imu", "frame": "eye"}},
        "attributes": {"arm": {"name": "limb", "formats": ["urdf"], "tag": "link"}},
    }
    made = package(robot, tmp_path, **keys)
    assert set(names(etree.fromstring(made.plain), "link")) == {"base", "limb", "eye"}
    assert parameters_of(made)["kept_broadcaster"]["frame_id"] == "eye"
    assert "lost_gyro" in losses(robot, **keys)["I-ROS2-SENSOR"]


@pytest.mark.parametrize(("kind", "interface"), [
    ({"type": "position"}, "position"),
    ({"type": "intvelocity"}, "velocity"),
    ({"type": "velocity", "kv": 1}, "velocity"),
    ({"type": "motor"}, "effort"),
    ({"type": "general", "gainprm": [1]}, "effort"),
])  # fmt: skip
def test_each_type_of_actuator_has_its_interface(kind, interface, tmp_path):
    robot = robot_with([joint("revolute", "base", "arm")])
    control = checked_control(package(robot, tmp_path, actuators={"*": kind}))
    assert names(control, "joint/command_interface") == [interface]
    # Speeds move mock hardware that works out no efforts.
    dynamics = control.findtext("hardware/param[@name='calculate_dynamics']")
    assert kind["type"] != "velocity" or dynamics == "true"
    assert control.findtext("hardware/plugin") == "mock_components/GenericSystem"


@pytest.mark.parametrize("multiplier", [-2.0, -406.88419829744066, 0.3047963227336805])
def test_follower_has_no_command(multiplier, tmp_path):
    rows = [joint("revolute", "base", "one"), joint("revolute", "base", "two", place=at(0, 1, 0))]
    robot = robot_with(rows, relations=[Relation("Gear", "two_joint", "one_joint", multiplier, 0.0)])
    keys = {"actuators": {"one_joint": "position", "two_joint": "position"}}
    checked_control(package(robot, tmp_path, **keys))
    assert losses(robot, **keys)["I-ROS2-FOLLOWER"].endswith(": two_joint")


def test_joints_start_at_home(tmp_path):
    robot, keys = driven()
    rows = []
    for row in robot.joints:
        values = [(0.8, 0.36, 0.48, 0.0) if dof.kind == "ball" else 0.1 for dof in row.dofs]
        dofs = tuple(replace(dof, saved=value) for dof, value in zip(row.dofs, values, strict=True))
        rows.append(replace(row, dofs=dofs))
    saved = replace(robot, joints=tuple(rows))
    made = package(saved, tmp_path, actuators=keys["actuators"])
    engine = Pinocchio(made.plain)
    actual, expected = engine.poses(home_of(made.expanded())), engine.poses(home(saved))
    assert max(np.abs(actual[link] - expected[link]).max() for link in actual) < TOLERANCE


def test_xacro_like_text_of_the_user_stays_as_it_is(tmp_path):
    robot = robot_with([joint("revolute", "base", "arm")])
    xml = "<gazebo reference='arm' more='$(x)'><plugin name='${a}'>$(find b) ${c}</plugin></gazebo>"
    made = package(robot, tmp_path, elements={"more": {"into": {"tag": "robot"}, "xml": xml}})
    for prefix in ("", "left_"):
        same_text(made.plain, made.expanded(prefix=prefix), prefix)


def test_hardware_of_the_source_replaces_mock_hardware(tmp_path):
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
    assert [(param.get("name"), param.text) for param in control.findall("joint/param")] == [("can_id", "7")]
    limits = control.findall("joint/command_interface[@name='effort']/param")
    assert [(limit.get("name"), limit.text) for limit in limits] == [("min", "-2.5"), ("max", "3")]
    assert parameters_of(made)["effort_controller"]["joints"] == ["arm_joint"]
    assert "I-ROS2-CONTROL" in losses(robot)
    other = made.expanded(use_mock_hardware="false", hardware_plugin="his/Arm")
    assert etree.fromstring(other).findtext("ros2_control/hardware/plugin") == "his/Arm"
    none = package(robot_with([joint("revolute", "base", "arm")]), tmp_path / "none")
    with pytest.raises(xacro.XacroException, match="hardware_plugin"):
        none.expanded(use_mock_hardware="false")


def test_launch_files_start_nodes_of_named_packages(tmp_path, monkeypatch):
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
    assert [node.package for node in nodes] == ["robot_state_publisher", "joint_state_publisher"]
    assert set(nodes[1].parameters[0]["zeros"]) == {f"l_{name}" for name in zeros["zeros"]}
    for prefix in ("", "l_"):
        state, manager, *spawners = launched(made, "control.launch.py", monkeypatch, prefix=prefix)
        assert manager.executable == "ros2_control_node"
        urdf = state.parameters[0]["robot_description"].value.encode()
        tree = yaml.safe_load(Path(manager.parameters[0]).read_text())
        if not prefix:
            assert manager.parameters == [str(made.folder / "config" / "controllers.yaml")]
        check_control(made, urdf, tree, prefix)
        controllers = set(tree["controller_manager"]["ros__parameters"]) - {"update_rate"}
        assert {spawner.arguments[0] for spawner in spawners} == controllers
        assert all(spawner.executable == "spawner" for spawner in spawners)


def painted():
    robot = robot_with([joint("revolute", "base", "arm")])
    shapes = (
        Shape("base", "visual", "base.obj", (1.0, 0.0, 0.0, 1.0), 3, 1, 1.0, 0.0),
        Shape("arm", "visual", "arm.obj", (1.0, 1.0, 1.0, 1.0), 3, 1, 1.0, 0.0, texture="wood.png"),
    )
    triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n# "
    names = ("base.obj", "arm.obj", "arm.mtl", "wood.png")
    return robot, Geometry(shapes, {name: f"{triangle}{name}".encode() for name in names})


def test_paths_of_meshes_exist_and_rviz_shows_the_root(tmp_path):
    robot, geometry = painted()
    files = geometry.files
    for meshes in ("relative", "package"):
        made = package(robot, tmp_path / meshes, geometry, export={"ros2": {}, "urdf": {"meshes": meshes}})
        for urdf in (made.plain, made.expanded()):
            same_text(made.plain, made.expanded(prefix="left_"), "left_")
            root = etree.fromstring(urdf)
            uris = [mesh.get("filename") for mesh in root.iter("mesh", "texture")]
            assert len(uris) == 3
            assert all(made.file_of(uri).read_bytes() == files[made.file_of(uri).name] for uri in uris)
        assert sorted(path.name for path in (made.folder / "meshes").iterdir()) == sorted(files)
        shown = yaml.safe_load((made.folder / "rviz" / "robot.rviz").read_text())["Visualization Manager"]
        assert shown["Global Options"]["Fixed Frame"] == "base"
        classes = [display["Class"] for display in shown["Displays"]]
        assert "rviz_default_plugins/RobotModel" in classes


def test_xml_of_the_user_is_in_the_package_without_the_urdf(tmp_path):
    robot = robot_with([joint("revolute", "base", "arm")])
    more = {"into": {"tag": "robot"}, "formats": ["urdf"], "xml": "<gazebo reference='arm'/>"}
    result = ros2_export(robot, export={"ros2": {}}, elements={"more": more})
    assert "robot.urdf" not in result.files
    made = packed(result.files, tmp_path)
    for text, link in ((made.plain, "arm"), (made.expanded(prefix="p_"), "p_arm")):
        assert etree.fromstring(text).find("gazebo").get("reference") == link
    # What the URDF cannot say is told for the package.
    assert messages_of(result, "I-URDF-UNSET")


def test_joints_of_a_loop_have_no_command(tmp_path):
    rows = [
        joint("revolute", "base", "one"),
        joint("revolute", "one", "two", place=at(1, 0, 0)),
        joint("revolute", "base", "three", place=at(0, 2, 0)),
    ]
    robot = robot_with(rows, loops=[loop("revolute", "two", "three", at(0, 2, 0), at(1, 0, 0), [0.0])])
    made = package(robot, tmp_path, actuators={"one_joint": "position"})
    checked_control(made)
    assert parameters_of(made)["joint_trajectory_controller"]["joints"] == ["one_joint"]
    stiff = package(robot_with([joint("fixed", "base", "arm")]), tmp_path / "stiff")
    assert etree.fromstring(stiff.expanded()).find("ros2_control") is None
    assert not (stiff.folder / "config").exists()
    assert "controller_manager" not in check_manifest(stiff)


def test_urdfdom_accepts_what_is_expanded(tmp_path):
    made = package(every_kind(), tmp_path)
    for prefix in ("", "left_"):
        path = tmp_path / "robot.urdf"
        path.write_bytes(made.expanded(prefix=prefix, parent="table"))
        assert check_urdf(path) == ""
