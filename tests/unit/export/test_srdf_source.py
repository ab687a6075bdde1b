"""The SRDF of a URDF source in what is built: groups, poses and pairs as they were, and checked."""

import json
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.export import export
from linkwright.stages.robot.model.robot import Robot
from tests.support.building import plan_of, write
from tests.support.pinocchio import pin
from tests.support.ros2 import moveit_of, packed
from tests.support.srdf import InPinocchio, Srdf
from tests.support.srdf_checks import srdf_checks
from tests.support.touching import geometry_of
from tests.support.urdfs import urdf_robot
from tests.unit.graph.urdf.test_srdf import GROUPS, URDF

SRDF = f"""<robot name="r">{GROUPS}
<group_state name="ready" group="all"><joint name="shoulder" value="0.5"/><joint name="elbow" value="-0.25"/>
<joint name="left_slide" value="0.125"/><joint name="right_slide" value="0.25"/></group_state>
<end_effector name="gripper" group="hand" parent_link="tool" parent_group="arm"/>
<virtual_joint name="mount" type="fixed" parent_frame="table" child_link="base"/>
<disable_collisions link1="left" link2="right" reason="User"/>
<disable_collisions link1="base" link2="lower" reason="Never"/>
<disable_collisions link1="upper" link2="left" reason="Default"/></robot>"""

JOINTS = {
    "arm": {"shoulder", "elbow"},
    "hand": {"left_slide", "right_slide"},
    "all": {"shoulder", "elbow", "left_slide", "right_slide"},
}
READY = {"shoulder": 0.5, "elbow": -0.25, "left_slide": 0.125, "right_slide": 0.25}
"""What the SRDF says."""

KEYS = {"export": {"urdf": {}, "mjcf": {}}, "contact": {"self": "auto"}, "actuators": {"*": "position"}}


def robot(text: str = SRDF, plan: Plan | None = None) -> Robot:
    return urdf_robot(URDF, plan or plan_of(**KEYS), srdf=text)


def built(folder: Path, text: str = SRDF, **keys: object) -> Srdf:
    plan = plan_of(**(KEYS | keys))
    made = robot(text, plan)
    files = write(made, folder, plan, geometry_of(made)).files
    return Srdf(files["robot.srdf"], files["robot.urdf"])


def test_groups_states_and_the_base_are_those_of_the_source(tmp_path: Path) -> None:
    written, source = built(tmp_path), Srdf(SRDF.encode(), URDF.encode())
    assert written.problems() == []
    assert written.groups == JOINTS
    for group, joints in JOINTS.items():
        assert written.states(group)["ready"] == {name: READY[name] for name in joints}
    for tag in ("virtual_joint", "end_effector"):
        assert [dict(one.attrib) for one in written.root.iter(tag)] == [
            dict(one.attrib) for one in source.root.iter(tag)
        ]
    chains = [dict(one.attrib) for one in written.root.iter("chain")]
    assert chains == [{"base_link": "base", "tip_link": "tool"}]


def test_pairs_are_written_with_the_reasons_of_the_source(tmp_path: Path) -> None:
    reasons = {frozenset(pair): reason for pair, reason in built(tmp_path).disabled.items()}
    assert reasons[frozenset(("left", "right"))] == "User"
    assert reasons[frozenset(("base", "lower"))] == "Never"
    assert reasons[frozenset(("upper", "left"))] == "Default"


def test_pinocchio_reads_the_same_pose_and_leaves_out_the_same_pairs(tmp_path: Path) -> None:
    built(tmp_path)
    model = pin.buildModelFromXML(URDF)
    pin.loadReferenceConfigurationsFromXML(model, SRDF)
    ready = model.referenceConfigurations["ready"]
    expected = {name: ready[model.joints[model.getJointId(name)].idx_q] for name in READY}
    reader = InPinocchio(tmp_path, "robot")
    assert reader.states()["ready"] == pytest.approx(expected, abs=1e-12)
    pairs = [
        {node.get("link1"), node.get("link2")} for node in etree.fromstring(SRDF).iter("disable_collisions")
    ]
    assert not [pair for pair in pairs if frozenset(pair) in reader.active()]


def test_pairs_that_may_touch_do_not_collide_and_those_that_never_do_still_may() -> None:
    made = robot()
    geometry = geometry_of(made)
    excludes = {(one.link_a, one.link_b): one.reason for one in geometry.excludes}
    assert excludes["left", "right"] == "Source"
    assert excludes["upper", "left"] == "Source"
    assert ("base", "lower") not in excludes


def test_fingers_within_each_other_at_home_touch_only_without_the_srdf() -> None:
    """The two fingers of the URDF have one place."""
    assert [
        one for one in geometry_of(robot()).touching if {one.link_a, one.link_b} == {"left", "right"}
    ] == []
    bare = geometry_of(urdf_robot(URDF, plan_of(**KEYS)))
    pairs = {frozenset((one.link_a, one.link_b)) for one in (*bare.touching, *bare.excludes)}
    assert frozenset(("left", "right")) in pairs


def test_the_user_lets_all_pairs_collide() -> None:
    geometry = geometry_of(robot(), self="all")
    assert [one for one in geometry.excludes if one.reason == "Source"] == []


def test_robot_json_has_the_semantics_and_is_read_back(tmp_path: Path) -> None:
    built(tmp_path)
    table = json.loads((tmp_path / "robot.json").read_text())
    assert [group["name"] for group in table["semantics"]["groups"]] == ["arm", "hand", "all"]
    assert [one for one in srdf_checks(tmp_path) if not one.passed] == []


@pytest.mark.parametrize(
    ("old", "new", "element"),
    [
        ('<group name="hand">', '<group name="claw">', 'group "hand"'),
        ('<joint name="right_slide"/>', '<joint name="elbow"/>', 'group "hand"'),
        ('group="hand" parent_group="arm"', 'group="all" parent_group="arm"', 'end_effector "gripper"'),
        ('<end_effector name="gripper"', '<end_effector name="claw"', 'end_effector "gripper"'),
        ('parent_frame="table"', 'parent_frame="floor"', 'virtual_joint "mount"'),
        ('link2="right" reason="User"', 'link2="right" reason="Never"', 'disable_collisions "left" "right"'),
    ],
)
def test_what_differs_from_the_source_is_found(tmp_path: Path, old: str, new: str, element: str) -> None:
    built(tmp_path)
    path = tmp_path / "robot.srdf"
    text = path.read_text()
    assert old in text, text
    path.write_text(text.replace(old, new, 1))
    assert element in [found.element for one in srdf_checks(tmp_path) for found in one.findings]


def test_moveits_package_has_the_groups_of_the_source(tmp_path: Path) -> None:
    plan = plan_of(**(KEYS | {"export": {"ros2": {}}}))
    made = robot(plan=plan)
    package = packed(export(made, geometry_of(made), plan).files, tmp_path)
    (path,) = (moveit_of(package).folder / "config").glob("*.srdf")
    found = Srdf(path.read_bytes(), package.plain)
    assert found.problems() == []
    assert found.groups == JOINTS
    assert [one.get("name") for one in found.root.iter("end_effector")] == ["gripper"]


def test_passive_joints_have_no_actuator_unless_they_are_named(tmp_path: Path) -> None:
    text = SRDF.replace("</robot>", '<passive_joint name="right_slide"/></robot>')
    written = built(tmp_path, text)
    assert [one.get("name") for one in written.root.iter("passive_joint")] == ["right_slide"]
    actuators = json.loads((tmp_path / "robot.json").read_text())["actuators"]
    assert [one["dof"] for one in actuators] == ["shoulder", "elbow", "left_slide"]
    named = built(tmp_path, text, actuators={"*": "position", "right_slide": "position"})
    assert not list(named.root.iter("passive_joint"))


def test_a_passive_joint_that_a_glob_matches_is_reported(tmp_path: Path) -> None:
    text = SRDF.replace("</robot>", '<passive_joint name="right_slide"/></robot>')
    plan = plan_of(**KEYS)
    made = robot(text, plan)
    log = write(made, tmp_path, plan, geometry_of(made)).diagnostics
    assert [one for one in log if one.code == "I-ACTUATOR" and "right_slide" in one.message]


def test_the_pose_is_a_keyframe_of_the_mjcf(tmp_path: Path) -> None:
    built(tmp_path)
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "ready")
    assert {name: model.key_qpos[number][model.joint(name).qposadr[0]] for name in READY} == READY
    assert np.isfinite(model.key_ctrl[number]).all()
