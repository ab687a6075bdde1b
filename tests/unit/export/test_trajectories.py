"""The controllers of ROS 2 that follow trajectories: a controller for each arm and each gripper."""

import pytest

from linkwright.stages.robot.model.robot import Relation
from tests.support.building import plan_of
from tests.support.exports import exported
from tests.support.robots import at, joint, robot_with
from tests.support.ros2 import packed
from tests.support.touching import box, geometry_of
from tests.support.urdfs import urdf_robot
from tests.unit.export.test_moveit import check, config
from tests.unit.export.test_srdf_source import SRDF
from tests.unit.graph.urdf.test_srdf import GROUPS, URDF

POSITION = {"actuators": {"*": "position"}}


def made(robot, folder, **keys):
    keys = {"export": {"ros2": {}}, **POSITION} | keys
    return packed(exported(robot, geometry_of(robot), **keys).files, folder)


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
    package = made(robot, tmp_path)
    if whole:
        check(package)
    assert trajectories(package) == expected


def test_wheels_are_commanded_by_speed_and_follow_no_trajectory(tmp_path):
    robot = hinges("base upper", "base left_wheel", "base right_wheel")
    keys = {"actuators": {"upper_joint": "position", "*wheel*": {"type": "velocity"}}}
    package = made(robot, tmp_path, **keys)
    check(package)
    assert trajectories(package) == {"joint_trajectory_controller": ["upper_joint"]}
    wheels = package.controllers()["velocity_controller"]["ros__parameters"]
    assert wheels["joints"] == ["left_wheel_joint", "right_wheel_joint"]
