"""The SRDF of a URDF source: what of it the robot has, by its own names, and what is left out by name."""

import math

import pytest

from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.model.semantics import (
    NOTHING_MORE,
    DisabledPair,
    EndEffector,
    JointGroup,
    VirtualJoint,
)
from linkwright.stages.robot.motion.start_pose import keyframes
from tests.support.building import plan_of
from tests.support.urdfs import urdf_robot

BODY = '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
BOX = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
LIMIT = '<limit lower="-1" upper="2" effort="3" velocity="4"/>'


def link(name: str, inside: str = BODY + BOX) -> str:
    return f'<link name="{name}">{inside}</link>'


def joint(name: str, parent: str, child: str, kind: str = "revolute") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    place = '<origin xyz="0 0 0.3"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{place}<axis xyz="0 1 0"/>{LIMIT}</joint>'


URDF = "".join(
    (
        '<robot name="r">',
        *(link(name) for name in ("base", "upper", "lower", "left", "right")),
        link("tool", ""),
        joint("shoulder", "base", "upper"),
        joint("elbow", "upper", "lower"),
        joint("tool_mount", "lower", "tool", "fixed"),
        joint("left_slide", "lower", "left", "prismatic"),
        joint("right_slide", "lower", "right", "prismatic"),
        "</robot>",
    )
)
"""An arm of two turns, a tool point, and two fingers on it."""

GROUPS = """<group name="arm"><chain base_link="base" tip_link="tool"/></group>
<group name="hand"><link name="left"/><joint name="right_slide"/></group>
<group name="all"><group name="arm"/><group name="hand"/></group>"""


def read(srdf: str, **keys: object) -> Robot:
    return urdf_robot(URDF, plan_of(**keys), srdf=f'<robot name="r">{srdf}</robot>')


def messages(robot: Robot, code: str) -> str:
    return "\n".join(one.message for one in robot.diagnostics if one.code == code)


def test_groups_have_the_joints_of_their_chains_links_and_groups() -> None:
    assert read(GROUPS).semantics.groups == (
        JointGroup("arm", ("shoulder", "elbow"), "base", "tool"),
        JointGroup("hand", ("right_slide", "left_slide")),
        JointGroup("all", ("shoulder", "elbow", "right_slide", "left_slide")),
    )


def test_states_of_one_name_are_one_keyframe_and_home_is_home() -> None:
    robot = read(
        GROUPS + '<group_state name="ready" group="arm"><joint name="shoulder" value="0.5"/>'
        '<joint name="elbow" value="-0.5"/></group_state>'
        '<group_state name="ready" group="hand"><joint name="left_slide" value="0.25"/></group_state>'
        '<group_state name="home" group="arm"><joint name="elbow" value="1.5"/></group_state>'
    )
    poses = keyframes(robot)
    assert poses["ready"] == {"shoulder": 0.5, "elbow": -0.5, "left_slide": 0.25, "right_slide": 0.0}
    assert poses["home"]["elbow"] == 1.5
    assert "W-SRDF" not in [one.code for one in robot.diagnostics]


def test_a_users_keyframe_wins_and_null_leaves_a_state_out() -> None:
    states = "".join(
        f'<group_state name="{name}" group="arm"><joint name="elbow" value="1"/></group_state>'
        for name in ("ready", "rest")
    )
    poses = keyframes(read(GROUPS + states, keyframes={"ready": {"elbow": 0.5}, "rest": None}))
    assert poses["ready"]["elbow"] == 0.5
    assert "rest" not in poses


def test_a_state_beyond_the_limits_is_brought_within_them() -> None:
    state = '<group_state name="far" group="arm"><joint name="elbow" value="2.5"/></group_state>'
    robot = read(GROUPS + state)
    assert keyframes(robot)["far"]["elbow"] == 2.0
    assert [(one.code, one.where) for one in robot.diagnostics if one.code.startswith("W-")] == [
        ("W-KEYFRAME", "far")
    ]


def test_pairs_keep_their_reasons_and_the_robots_order() -> None:
    pairs = read(
        '<disable_collisions link1="left" link2="right" reason="User"/>'
        '<disable_collisions link1="lower" link2="base" reason="Never"/>'
        '<disable_collisions link1="upper" link2="left"/>'
    ).semantics.disabled
    assert pairs == (
        DisabledPair("left", "right", "User"),
        DisabledPair("base", "lower", "Never"),
        DisabledPair("upper", "left", ""),
    )
    assert [pair.touches for pair in pairs] == [True, False, True]


def test_the_default_of_a_link_disables_all_but_enabled_pairs() -> None:
    robot = read('<disable_default_collisions link="left"/><enable_collisions link1="left" link2="base"/>')
    pairs = {frozenset((pair.link_a, pair.link_b)) for pair in robot.semantics.disabled}
    assert pairs == {frozenset(("left", name)) for name in ("upper", "lower", "right")}


def test_end_effectors_and_passive_joints_are_read() -> None:
    robot = read(
        GROUPS + '<end_effector name="gripper" group="hand" parent_link="tool" parent_group="arm"/>'
        '<passive_joint name="right_slide"/>'
    )
    assert robot.semantics.end_effectors == (EndEffector("gripper", "hand", "tool", "arm"),)
    assert robot.semantics.passive == ("right_slide",)


@pytest.mark.parametrize(("kind", "fixed"), [("fixed", True), ("floating", False)])
def test_the_virtual_joint_says_whether_the_base_is_fixed(kind: str, fixed: bool) -> None:
    joint = f'<virtual_joint name="mount" type="{kind}" parent_frame="table" child_link="base"/>'
    robot = read(joint)
    assert robot.base.fixed is fixed
    assert robot.semantics.virtual_joint == VirtualJoint("mount", "table")
    assert "I-URDF-BASE" not in [one.code for one in robot.diagnostics]
    assert read(joint, root={"base": "free" if fixed else "fixed"}).base.fixed is not fixed


def test_what_the_urdf_does_not_have_is_named_and_left_out() -> None:
    robot = read(
        GROUPS + '<group name="legs"><joint name="knee"/><chain base_link="base" tip_link="foot"/></group>'
        '<group_state name="up" group="legs"><joint name="hip" value="1"/></group_state>'
        '<disable_collisions link1="base" link2="head" reason="User"/>'
        '<end_effector name="paw" group="legs" parent_link="hand"/>'
        '<passive_joint name="wheel"/>'
    )
    told = messages(robot, "W-SRDF")
    for name in ("joint knee", "link foot", "joint hip", "link head", "link hand", "joint wheel"):
        assert f"the {name}" in told
    assert "legs" not in [group.name for group in robot.semantics.groups]
    assert robot.semantics.disabled == robot.semantics.end_effectors == robot.semantics.passive == ()
    assert "up" not in keyframes(robot)


def test_what_no_robot_can_have_is_named_and_left_out() -> None:
    robot = read(
        GROUPS + '<group name="arm"><joint name="elbow"/></group>'
        '<group name="nothing"><joint name="tool_mount"/></group>'
        '<virtual_joint name="plane" type="planar" parent_frame="odom" child_link="base"/>'
        '<group_state name="bad" group="arm"><joint name="elbow" value="half"/></group_state>'
        '<group_state name="ready" group="arm"><joint name="elbow" value="1"/></group_state>'
        '<group_state name="ready" group="all"><joint name="elbow" value="2"/></group_state>'
        '<link_sphere_approximation link="base"/>'
    )
    told = messages(robot, "W-SRDF")
    for words in (
        "the second group arm",
        "the group nothing",
        "the virtual joint plane: the base cannot be planar",
        "the value of elbow in the state bad",
        "a second value of elbow in the state ready",
        "<link_sphere_approximation>",
    ):
        assert words in told
    assert keyframes(robot)["ready"]["elbow"] == 1.0


def test_a_group_within_itself_is_named() -> None:
    robot = read(
        '<group name="a"><group name="b"/><joint name="elbow"/></group>'
        '<group name="b"><group name="a"/><joint name="shoulder"/></group>'
    )
    joints = {group.name: set(group.joints) for group in robot.semantics.groups}
    assert joints == {"a": {"shoulder", "elbow"}, "b": {"shoulder"}}
    assert "the group a within itself" in messages(robot, "W-SRDF")


def test_values_that_are_not_finite_are_no_pose() -> None:
    state = f'<group_state name="far" group="arm"><joint name="elbow" value="{math.inf}"/></group_state>'
    robot = read(GROUPS + state)
    assert "far" not in keyframes(robot)
    assert "the value of elbow in the state far" in messages(robot, "W-SRDF")


def test_names_of_the_robot_are_used_where_they_changed() -> None:
    robot = read(
        GROUPS + '<disable_collisions link1="left" link2="right" reason="User"/>',
        names={"links": {"left": "finger"}, "joints": {"elbow": "bend"}},
    )
    assert robot.semantics.groups[0].joints == ("shoulder", "bend")
    assert {robot.semantics.disabled[0].link_a, robot.semantics.disabled[0].link_b} == {"finger", "right"}


def test_without_an_srdf_a_robot_has_no_semantics() -> None:
    robot = urdf_robot(URDF)
    assert robot.semantics == NOTHING_MORE
    assert "I-SRDF" not in [one.code for one in robot.diagnostics]
