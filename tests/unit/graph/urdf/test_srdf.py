"""The SRDF of a URDF source: what of it the robot has, by its own names, and what is left out by name."""

import pytest

from linkwright.stages.robot.model.semantics import (
    NO_SEMANTICS,
    DisabledPair,
    EndEffector,
    JointGroup,
    VirtualJoint,
)
from linkwright.stages.robot.motion.start_pose import keyframes
from tests.support.building import plan_of
from tests.support.exports import messages_of
from tests.support.reported import codes
from tests.support.urdfs import urdf_robot
from tests.unit.graph.urdf.test_reader import BODY, LIMIT, joint, link, robot_text

BOX = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
UP = f'<origin xyz="0 0 0.3"/>{LIMIT}'
JOINTS = (
    ("shoulder", "base", "upper", "revolute"),
    ("elbow", "upper", "lower", "revolute"),
    ("tool_mount", "lower", "tool", "fixed"),
    ("left_slide", "lower", "left", "prismatic"),
    ("right_slide", "lower", "right", "prismatic"),
)
LINKS = [link(name, BODY + BOX) for name in ("base", "upper", "lower", "left", "right")]
URDF = robot_text(*LINKS, link("tool", ""), *(joint(*row, UP) for row in JOINTS)).replace("0 0 1", "0 1 0")

GROUPS = """<group name="arm"><chain base_link="base" tip_link="tool"/></group>
<group name="hand"><link name="left"/><joint name="right_slide"/></group>
<group name="all"><group name="arm"/><group name="hand"/></group>"""


def read(srdf, **keys):
    return urdf_robot(URDF, plan_of(**keys), srdf=f'<robot name="r">{srdf}</robot>')


def messages(robot):
    return "\n".join(messages_of(robot, "W-SRDF"))


def state(name, group, **values):
    joints = "".join(f'<joint name="{joint}" value="{value}"/>' for joint, value in values.items())
    return f'<group_state name="{name}" group="{group}">{joints}</group_state>'


def test_groups_have_the_joints_of_their_chains_links_and_groups():
    assert read(GROUPS).semantics.groups == (
        JointGroup("arm", ("shoulder", "elbow"), "base", "tool"),
        JointGroup("hand", ("right_slide", "left_slide")),
        JointGroup("all", ("shoulder", "elbow", "right_slide", "left_slide")),
    )


def test_states_of_one_name_are_one_keyframe_and_home_is_home():
    robot = read(
        GROUPS
        + state("ready", "arm", shoulder=0.5, elbow=-0.5)
        + state("ready", "hand", left_slide=0.25)
        + state("home", "arm", elbow=1.5)
    )
    poses = keyframes(robot)
    assert poses["ready"] == {"shoulder": 0.5, "elbow": -0.5, "left_slide": 0.25, "right_slide": 0.0}
    assert poses["home"]["elbow"] == 1.5
    assert "W-SRDF" not in codes(robot)


def test_a_users_keyframe_wins_and_null_leaves_a_state_out():
    states = "".join(state(name, "arm", elbow=1) for name in ("ready", "rest"))
    poses = keyframes(read(GROUPS + states, keyframes={"ready": {"elbow": 0.5}, "rest": None}))
    assert (poses["ready"]["elbow"], "rest" in poses) == (0.5, False)


@pytest.mark.parametrize(("value", "pose"), [("2.5", 2.0), ("inf", None)])
def test_a_finite_state_beyond_the_limits_is_brought_within_them(value, pose):
    robot = read(GROUPS + state("far", "arm", elbow=value))
    assert keyframes(robot).get("far", {}).get("elbow") == pose
    assert [code for code in codes(robot) if code[0] == "W"] == ["W-KEYFRAME" if pose else "W-SRDF"]
    assert pose or "the value of elbow in the state far" in messages(robot)


def test_pairs_keep_their_reasons_and_the_robots_order():
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


def test_the_default_of_a_link_disables_all_but_enabled_pairs():
    robot = read('<disable_default_collisions link="left"/><enable_collisions link1="left" link2="base"/>')
    pairs = {frozenset((pair.link_a, pair.link_b)) for pair in robot.semantics.disabled}
    assert pairs == {frozenset(("left", name)) for name in ("upper", "lower", "right")}


def test_end_effectors_and_passive_joints_are_read():
    robot = read(
        GROUPS + '<end_effector name="gripper" group="hand" parent_link="tool" parent_group="arm"/>'
        '<passive_joint name="right_slide"/>'
    )
    assert robot.semantics.end_effectors == (EndEffector("gripper", "hand", "tool", "arm"),)
    assert robot.semantics.passive == ("right_slide",)


@pytest.mark.parametrize(("kind", "fixed"), [("fixed", True), ("floating", False)])
def test_the_virtual_joint_says_whether_the_base_is_fixed(kind, fixed):
    joint = f'<virtual_joint name="mount" type="{kind}" parent_frame="table" child_link="base"/>'
    robot = read(joint)
    assert robot.base.fixed is fixed
    assert robot.semantics.virtual_joint == VirtualJoint("mount", "table")
    assert "I-URDF-BASE" not in codes(robot)
    assert read(joint, root={"base": "free" if fixed else "fixed"}).base.fixed is not fixed


LEFT_OUT = {
    "what the URDF does not have": (
        '<group name="legs"><joint name="knee"/><chain base_link="base" tip_link="foot"/></group>'
        '<disable_collisions link1="base" link2="head" reason="User"/><passive_joint name="wheel"/>'
        '<end_effector name="paw" group="legs" parent_link="hand"/>' + state("up", "legs", hip=1),
        "the joint knee, the link foot, the joint hip, the link head, the link hand, the joint wheel",
    ),
    "what no robot can have": (
        '<group name="arm"><joint name="elbow"/></group><group name="legs"><joint name="tool_mount"/></group>'
        '<virtual_joint name="plane" type="planar" parent_frame="odom" child_link="base"/>'
        '<link_sphere_approximation link="base"/>' + state("bad", "arm", elbow="half")
        + state("ready", "arm", elbow=1) + state("ready", "all", elbow=2),
        "the second group arm, the group legs, the virtual joint plane: the base cannot be planar, "
        "the value of elbow in the state bad, a second value of elbow in the state ready, "
        "<link_sphere_approximation>",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", LEFT_OUT)
def test_impossible_entries_are_named_and_left_out(case):
    text, words = LEFT_OUT[case]
    robot, warnings = read(GROUPS + text), messages(read(GROUPS + text))
    assert [phrase for phrase in words.split(", ") if phrase not in warnings] == []
    assert "legs" not in [group.name for group in robot.semantics.groups]
    assert robot.semantics.disabled == robot.semantics.end_effectors == robot.semantics.passive == ()
    poses = keyframes(robot)
    assert not {"up", "bad"} & set(poses)
    assert poses.get("ready", {}).get("elbow") == (1.0 if "ready" in text else None)


def test_a_group_within_itself_is_named():
    robot = read(
        '<group name="a"><group name="b"/><joint name="elbow"/></group>'
        '<group name="b"><group name="a"/><joint name="shoulder"/></group>'
    )
    joints = {group.name: set(group.joints) for group in robot.semantics.groups}
    assert joints == {"a": {"shoulder", "elbow"}, "b": {"shoulder"}}
    assert "the group a within itself" in messages(robot)


def test_names_of_the_robot_are_used_where_they_changed():
    robot = read(
        GROUPS + '<disable_collisions link1="left" link2="right" reason="User"/>',
        names={"links": {"left": "finger"}, "joints": {"elbow": "bend"}},
    )
    assert robot.semantics.groups[0].joints == ("shoulder", "bend")
    assert {robot.semantics.disabled[0].link_a, robot.semantics.disabled[0].link_b} == {"finger", "right"}


def test_a_robot_without_an_srdf_has_no_semantics():
    assert urdf_robot(URDF).semantics == NO_SEMANTICS
    assert "I-SRDF" not in codes(urdf_robot(URDF))
