"""MoveIt's package beside the ROS 2 package, in which every name is known, and its trajectory controllers."""

import math
from pathlib import Path

import pytest
import yaml

from linkwright.stages.export.ros2.moveit import _real_text
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Relation, frozen
from tests.support.building import plan_of
from tests.support.exports import exported, messages_of
from tests.support.robots import at, joint, robot_with
from tests.support.ros2 import IncludeLaunchDescription, check_manifest, launched, moveit_of, packed
from tests.support.srdf import Srdf
from tests.support.touching import box, geometry_of
from tests.support.urdfs import urdf_robot
from tests.unit.export.test_srdf_source import SRDF
from tests.unit.graph.urdf.test_srdf import GROUPS, URDF

MOVING = Dynamics(effort=5.0, velocity=3.0)
POSITION = {"actuators": {"*": "position"}}


def chain(count, *, names=None, **more):
    """An arm of hinges, 0.2 m apart, each but the last with a box."""
    names = names or [f"l{n}" for n in range(count)]
    rows = []
    for above, name in zip(["base", *names], names, strict=False):
        limits = {f"{name}_joint": Limits(-1.0, 1.0)}
        rows.append(joint("revolute", above, name, place=at(0.2, 0, 0), limits=limits, dynamics=MOVING))
    return robot_with(rows, shapes=dict.fromkeys(["base", *names], (box(0.05, 0.05, 0.05),)), **more)


def made(robot, folder, ros2=None, **keys):
    return packed(exported(robot, geometry_of(robot), export={"ros2": ros2 or {}}, **keys).files, folder)


def config(package, name):
    """A file of MoveIt's package, as ROS reads it."""
    return yaml.safe_load((moveit_of(package).folder / "config" / f"{name}.yaml").read_text())


def semantic(package):
    (path,) = (moveit_of(package).folder / "config").glob("*.srdf")
    return Srdf(path.read_bytes(), package.plain)


def check(package):
    """Every name in the package means something."""
    srdf, moveit = semantic(package), moveit_of(package)
    assert srdf.problems() == []
    urdf, passive = srdf.joints, {node.get("name") for node in srdf.root.findall("passive_joint")}
    moving = {name for name, node in urdf.items() if srdf.moves(name) and node.find("mimic") is None}
    limits = config(package, "joint_limits")["joint_limits"]
    assert set(limits) == moving - passive
    for name, limit in limits.items():
        assert type(limit["max_velocity"]) is type(limit["max_acceleration"]) is float
        assert limit["max_velocity"] == pytest.approx(float(urdf[name].find("limit").get("velocity")))
        assert limit["max_acceleration"] > 0
        assert limit["has_velocity_limits"] is limit["has_acceleration_limits"] is True
    assert set(config(package, "kinematics")) <= set(srdf.groups)
    needs = check_manifest(moveit)
    assert package.name in needs
    if (moveit.folder / "config" / "moveit_controllers.yaml").exists():
        controllers, by_ros = config(package, "moveit_controllers"), package.controllers()
        manager = controllers["moveit_simple_controller_manager"]
        assert controllers["moveit_controller_manager"].partition("/")[0] in needs
        for name in manager["controller_names"]:
            parameters = by_ros[name]["ros__parameters"]
            assert manager[name]["joints"] == parameters["joints"]
            assert set(manager[name]["joints"]) <= set(limits)
            assert parameters["allow_partial_joints_goal"] is True
            kind = by_ros["controller_manager"]["ros__parameters"][name]["type"]
            assert kind == "joint_trajectory_controller/JointTrajectoryController"


@pytest.mark.parametrize("count", [1, 3, 5, 6, 7])
def test_arm_has_kinematics_limits_and_controllers(count, tmp_path):
    robot = chain(count)
    package = made(robot, tmp_path, **POSITION)
    check(package)
    kinematics = config(package, "kinematics")
    if count < 3:
        assert kinematics == {}
    else:
        (solver,) = kinematics.values()
        assert solver["kinematics_solver"] == "kdl_kinematics_plugin/KDLKinematicsPlugin"
        assert solver.get("position_only_ik", False) == (count < 6)
    limits = config(package, "joint_limits")["joint_limits"]
    assert (limits["l0_joint"]["max_velocity"], limits["l0_joint"]["max_acceleration"]) == (3.0, 6.0)


def test_names_illegal_in_ros_are_the_same_in_all_files(tmp_path):
    names = ["upper arm", "on", "1st/hand"]
    robot = chain(3, names=names, frames=[Frame("tool.tip", "1st/hand", frozen(at(0, 0, 0.1)), "")])
    robot_names = made(robot, tmp_path, **POSITION)
    check(robot_names)
    srdf = semantic(robot_names)
    assert set(srdf.groups) == {"tool_tip"}
    assert srdf.groups["tool_tip"] == {"upper_arm_joint", "on_joint", "joint_1st_hand_joint"}
    assert set(config(robot_names, "kinematics")) == {"tool_tip"}


def test_followers_have_no_limits_and_passive_joints_no_solver(tmp_path):
    robot = chain(4, relations=[Relation("gear", "l3_joint", "l2_joint", 0.5, 0.0)])
    package = made(robot, tmp_path, **POSITION)
    check(package)
    assert set(config(package, "joint_limits")["joint_limits"]) == {"l0_joint", "l1_joint", "l2_joint"}
    loose = made(chain(4), tmp_path / "loose", actuators={"*": "position", "l1_joint": "none"})
    check(loose)
    assert config(loose, "kinematics") == {}


@pytest.mark.parametrize("fixed", [True, False])
def test_launch_file_starts_move_group_with_its_parameters(fixed, tmp_path, monkeypatch):
    robot = chain(6, fixed=fixed)
    package = made(robot, tmp_path, **POSITION)
    moveit = moveit_of(package)
    group, frame, control, rviz = launched(moveit, "moveit.launch.py", monkeypatch)
    parameters = {key: value for part in group.parameters for key, value in part.items()}
    assert group.executable == "move_group"
    assert parameters["allow_trajectory_execution"] is True
    texts = (parameters[f"robot_description{ending}"].encode() for ending in ("_semantic", ""))
    semantics = Srdf(*texts)
    assert semantics.problems() == []
    assert set(parameters["robot_description_kinematics"]) == set(semantics.groups)
    assert frame.arguments == ["--frame-id", "world", "--child-frame-id", "base"]
    assert semantics.root.find("virtual_joint").get("parent_frame") == "world"
    assert isinstance(control, IncludeLaunchDescription)
    assert Path(control.source.path) == package.folder / "launch" / "control.launch.py"
    # What it is given are arguments of that file.
    assert launched(package, "control.launch.py", monkeypatch, **dict(control.launch_arguments))
    view = yaml.safe_load(Path(rviz.arguments[1]).read_text())
    assert view["Visualization Manager"]["Global Options"]["Fixed Frame"] == "world"
    planning = view["Visualization Manager"]["Displays"][1]["Planning Request"]
    assert planning["Planning Group"] in semantics.groups
    quiet = launched(moveit, "moveit.launch.py", monkeypatch, rviz="false", robot="false", stand="false")
    assert [node.executable for node in quiet] == ["move_group"]


def test_moveit_only_plans_without_position_control(tmp_path, monkeypatch):
    robot = chain(3)
    package = made(robot, tmp_path, actuators={"*": "motor"})
    check(package)
    assert not (moveit_of(package).folder / "config" / "moveit_controllers.yaml").exists()
    (group, *_) = launched(moveit_of(package), "moveit.launch.py", monkeypatch)
    assert group.parameters[1]["allow_trajectory_execution"] is False
    assert messages_of(exported(robot, export={"ros2": {}}, actuators={"*": "motor"}), "I-ROS2-MOVEIT")


def test_package_is_named_and_left_out_without_moving_joints(tmp_path):
    assert moveit_of(made(chain(3), tmp_path / "a", ros2={"moveit": False})) is None
    still = robot_with([joint("fixed", "base", "top")])
    assert moveit_of(made(still, tmp_path / "b")) is None
    named = made(chain(3), tmp_path / "c", ros2={"package": "arm_description"})
    assert moveit_of(named).name == "arm_moveit_config"


@pytest.mark.parametrize(
    ("value", "text"),
    [(3.0, "3.0"), (0.1 + 0.2, "0.3"), (1e-7, "1.0e-07"), (2.5e20, "2.5e+20"), (1e6, "1000000.0")],
)
def test_numbers_are_real_ones_to_yaml(value, text):
    assert _real_text(value) == text
    read = yaml.safe_load(text)
    assert type(read) is float
    assert math.isclose(read, value)


def trajectories(package):
    """The joints of each controller that follows trajectories; MoveIt has the same."""
    controllers = package.controllers()
    types = controllers["controller_manager"]["ros__parameters"]
    joints_of = {
        name: controllers[name]["ros__parameters"]["joints"]
        for name, about in types.items()
        if isinstance(about, dict) and about["type"].startswith("joint_trajectory_controller/")
    }
    manager = config(package, "moveit_controllers")["moveit_simple_controller_manager"]
    assert {name: manager[name]["joints"] for name in manager["controller_names"]} == joints_of
    return joints_of


def hinges(*ends, **more):
    """`parent child` of each hinge."""
    rows = [
        joint("revolute", *end.split(), place=at(0.2, 0.1 * number, 0)) for number, end in enumerate(ends)
    ]
    links = dict.fromkeys(["base", *(end.split()[1] for end in ends)], (box(0.05, 0.05, 0.05),))
    return robot_with(rows, shapes=links, **more)


HANDS = hinges("base torso", "torso left", "torso right", "left left_hand", "right right_hand")


FINGERS = hinges(
    "base upper", "upper lower", "lower left_finger", "lower right_finger",
    relations=[Relation("gears", "right_finger_joint", "left_finger_joint", -1.0, 0.0)],
)  # fmt: skip


REST, ARM = "joint_trajectory_controller", ["shoulder", "elbow"]


SLIDES = {"hand_controller": ["left_slide", "right_slide"]}


WITHIN = """<group name="arm"><chain base_link="base" tip_link="tool"/></group>
<group name="wrist"><joint name="elbow"/></group><group name="left"><link name="left"/></group>"""


CARRIES = """<group name="arm"><joint name="elbow"/></group><group name="hand"><link name="left"/></group>
<group name="arm_torso"><joint name="shoulder"/><joint name="elbow"/></group>
<group name="head"><joint name="right_slide"/></group>
<end_effector name="e" group="hand" parent_link="lower" parent_group="arm"/>"""


OWN_END = GROUPS + '<end_effector name="e" group="arm" parent_link="lower"/>'


CASES = {
    "an arm": (hinges("base upper", "upper lower"), {REST: ["upper_joint", "lower_joint"]}),
    "two arms and what they share": (HANDS, {
        REST: ["torso_joint"], "left_hand_controller": ["left_joint", "left_hand_joint"],
        "right_hand_controller": ["right_joint", "right_hand_joint"]}),
    "a gripper": (FINGERS, {
        REST: ["upper_joint", "lower_joint"], "gripper_controller": ["left_finger_joint"]}),
    "groups of the source": (SRDF, {REST: ARM, **SLIDES}),
    "a group made up of others": (GROUPS, {"arm_controller": ARM, **SLIDES}),
    "a group within another": (WITHIN, {
        REST: ["right_slide"], "arm_controller": ARM, "left_controller": ["left_slide"]}),
    "an arm carries an end effector": (CARRIES, {
        REST: ["shoulder"], "arm_controller": ["elbow"], "head_controller": ["right_slide"],
        "hand_controller": ["left_slide"]}),
    "an arm as its own end effector, as in a public SRDF of the Panda": (OWN_END, {
        "arm_controller": ARM, **SLIDES}),
}  # fmt: skip
"""Name → a robot, or the SRDF of a source, and the joints of each controller."""


@pytest.mark.parametrize(("robot", "expected"), CASES.values(), ids=CASES)
def test_each_arm_and_gripper_has_a_controller(robot, expected, tmp_path):
    whole = robot is not OWN_END  # its end effector has no parent group, which MoveIt's reader asks for
    if isinstance(robot, str):
        text = robot if "<robot" in robot else f'<robot name="r">{robot}</robot>'
        robot = urdf_robot(URDF, plan_of(**POSITION), srdf=text)
    package = made(robot, tmp_path, **POSITION)
    if whole:
        check(package)
    assert trajectories(package) == expected


def test_wheels_are_commanded_by_speed_and_follow_no_trajectory(tmp_path):
    robot = hinges("base upper", "base left_wheel", "base right_wheel")
    actuators = {"upper_joint": "position", "*wheel*": {"type": "velocity"}}
    package = made(robot, tmp_path, actuators=actuators)
    check(package)
    assert trajectories(package) == {"joint_trajectory_controller": ["upper_joint"]}
    wheels = package.controllers()["velocity_controller"]["ros__parameters"]
    assert wheels["joints"] == ["left_wheel_joint", "right_wheel_joint"]
