"""The controllers of ROS 2 that follow trajectories: a controller for each arm and each gripper."""

from pathlib import Path

import pytest

from linkwright.stages.export import export
from linkwright.stages.robot.model.robot import Relation, Robot
from tests.support.building import plan_of
from tests.support.robots import at, joint, robot_with
from tests.support.ros2 import Package, packed
from tests.support.touching import box, geometry_of
from tests.support.urdfs import urdf_robot
from tests.unit.export.test_moveit import check, config
from tests.unit.export.test_srdf_source import SRDF
from tests.unit.graph.urdf.test_srdf import GROUPS, URDF

POSITION = {"actuators": {"*": "position"}}


def made(robot: Robot, folder: Path, **keys: object) -> Package:
    plan = plan_of(**({"export": {"ros2": {}}, **POSITION} | keys))
    return packed(export(robot, geometry_of(robot), plan).files, folder)


def trajectories(package: Package) -> dict[str, list[str]]:
    """The joints of each controller that follows trajectories; MoveIt has the same."""
    own = package.controllers()
    types = own["controller_manager"]["ros__parameters"]
    found = {
        name: own[name]["ros__parameters"]["joints"]
        for name, about in types.items()
        if isinstance(about, dict) and about["type"].startswith("joint_trajectory_controller/")
    }
    manager = config(package, "moveit_controllers")["moveit_simple_controller_manager"]
    assert {name: manager[name]["joints"] for name in manager["controller_names"]} == found
    return found


def hinges(*ends: str, **more: object) -> Robot:
    """`parent child` of each hinge."""
    rows = [
        joint("revolute", *end.split(), place=at(0.2, 0.1 * number, 0)) for number, end in enumerate(ends)
    ]
    links = dict.fromkeys(["base", *(end.split()[1] for end in ends)], (box(0.05, 0.05, 0.05),))
    return robot_with(rows, shapes=links, **more)


def test_a_single_arm_has_the_controller_of_all_joints(tmp_path: Path) -> None:
    package = made(hinges("base upper", "upper lower"), tmp_path)
    check(package)
    assert trajectories(package) == {"joint_trajectory_controller": ["upper_joint", "lower_joint"]}


def test_each_arm_has_a_controller_and_the_joints_that_they_share_another(tmp_path: Path) -> None:
    robot = hinges("base torso", "torso left", "torso right", "left left_hand", "right right_hand")
    assert trajectories(made(robot, tmp_path)) == {
        "joint_trajectory_controller": ["torso_joint"],
        "left_hand_controller": ["left_joint", "left_hand_joint"],
        "right_hand_controller": ["right_joint", "right_hand_joint"],
    }


def test_a_gripper_has_a_controller_of_its_own(tmp_path: Path) -> None:
    gears = [Relation("gears", "right_finger_joint", "left_finger_joint", -1.0, 0.0)]
    ends = ("base upper", "upper lower", "lower left_finger", "lower right_finger")
    assert trajectories(made(hinges(*ends, relations=gears), tmp_path)) == {
        "joint_trajectory_controller": ["upper_joint", "lower_joint"],
        "gripper_controller": ["left_finger_joint"],
    }


def test_wheels_are_commanded_by_speed_and_follow_no_trajectory(tmp_path: Path) -> None:
    robot = hinges("base upper", "base left_wheel", "base right_wheel")
    keys = {"actuators": {"upper_joint": "position", "*wheel*": {"type": "velocity"}}}
    package = made(robot, tmp_path, **keys)
    check(package)
    assert trajectories(package) == {"joint_trajectory_controller": ["upper_joint"]}
    wheels = package.controllers()["velocity_controller"]["ros__parameters"]
    assert wheels["joints"] == ["left_wheel_joint", "right_wheel_joint"]


def of_source(groups: str, folder: Path) -> Package:
    text = groups if "<robot" in groups else f'<robot name="r">{groups}</robot>'
    return made(urdf_robot(URDF, plan_of(**POSITION), srdf=text), folder)


def test_groups_of_the_source_choose_the_controllers(tmp_path: Path) -> None:
    package = of_source(SRDF, tmp_path)
    check(package)
    assert trajectories(package) == {
        "joint_trajectory_controller": ["shoulder", "elbow"],
        "hand_controller": ["left_slide", "right_slide"],
    }


@pytest.mark.parametrize(
    ("groups", "expected"),
    [
        # A group that others make up is none of its own.
        (
            GROUPS,
            {"arm_controller": ["shoulder", "elbow"], "hand_controller": ["left_slide", "right_slide"]},
        ),
        # A group within another neither; what no group has is with the others.
        (
            '<group name="arm"><chain base_link="base" tip_link="tool"/></group>'
            '<group name="wrist"><joint name="elbow"/></group><group name="left"><link name="left"/></group>',
            {
                "joint_trajectory_controller": ["right_slide"],
                "arm_controller": ["shoulder", "elbow"],
                "left_controller": ["left_slide"],
            },
        ),
        # What carries an end effector is an arm, though another group goes further.
        (
            '<group name="arm"><joint name="elbow"/></group><group name="hand"><link name="left"/></group>'
            '<group name="arm_torso"><joint name="shoulder"/><joint name="elbow"/></group>'
            '<group name="head"><joint name="right_slide"/></group>'
            '<end_effector name="e" group="hand" parent_link="lower" parent_group="arm"/>',
            {
                "joint_trajectory_controller": ["shoulder"],
                "arm_controller": ["elbow"],
                "head_controller": ["right_slide"],
                "hand_controller": ["left_slide"],
            },
        ),
    ],
)
def test_groups_that_overlap_give_each_joint_one_controller(
    groups: str, expected: dict[str, list[str]], tmp_path: Path
) -> None:
    package = of_source(groups, tmp_path)
    check(package)
    assert trajectories(package) == expected


def test_an_arm_may_be_the_group_of_its_own_end_effector(tmp_path: Path) -> None:
    """As in a public SRDF of the Panda."""
    package = of_source(GROUPS + '<end_effector name="e" group="arm" parent_link="lower"/>', tmp_path)
    assert trajectories(package) == {
        "arm_controller": ["shoulder", "elbow"],
        "hand_controller": ["left_slide", "right_slide"],
    }
