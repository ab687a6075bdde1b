"""The SRDF of a URDF source in what is built: groups, poses and pairs as they were, and checked."""

import json

import numpy as np
import pytest
from lxml import etree

from linkwright.stages.export import export
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


def robot(text=SRDF, plan=None):
    return urdf_robot(URDF, plan or plan_of(**KEYS), srdf=text)


def built(folder, text=SRDF, **keys):
    plan = plan_of(**(KEYS | keys))
    made = robot(text, plan)
    files = write(made, folder, plan, geometry_of(made)).files
    return Srdf(files["robot.srdf"], files["robot.urdf"])


def test_groups_states_and_the_base_are_those_of_the_source(tmp_path):
    written, source = built(tmp_path), Srdf(SRDF.encode(), URDF.encode())
    assert (written.problems(), written.groups) == ([], JOINTS)
    for group, joints in JOINTS.items():
        assert written.states(group)["ready"] == {name: READY[name] for name in joints}
    for tag in ("virtual_joint", "end_effector"):
        assert [dict(element.attrib) for element in written.root.iter(tag)] == [
            dict(element.attrib) for element in source.root.iter(tag)
        ]
    chains = [dict(chain.attrib) for chain in written.root.iter("chain")]
    assert chains == [{"base_link": "base", "tip_link": "tool"}]


def test_pairs_are_written_with_the_reasons_of_the_source(tmp_path):
    reasons = {frozenset(pair): reason for pair, reason in built(tmp_path).disabled.items()}
    assert reasons[frozenset(("left", "right"))] == "User"
    assert reasons[frozenset(("base", "lower"))] == "Never"
    assert reasons[frozenset(("upper", "left"))] == "Default"


def test_pinocchio_reads_the_same_pose_and_pairs(tmp_path):
    built(tmp_path)
    model = pin.buildModelFromXML(URDF)
    pin.loadReferenceConfigurationsFromXML(model, SRDF)
    ready = model.referenceConfigurations["ready"]
    expected = {name: ready[model.joints[model.getJointId(name)].idx_q] for name in READY}
    reader = InPinocchio(tmp_path)
    assert reader.states()["ready"] == pytest.approx(expected, abs=1e-12)
    pairs = [
        {node.get("link1"), node.get("link2")} for node in etree.fromstring(SRDF).iter("disable_collisions")
    ]
    assert not [pair for pair in pairs if frozenset(pair) in reader.active()]


def test_pairs_of_the_source_do_not_collide_unless_never():
    made = robot()
    geometry = geometry_of(made)
    excludes = {(exclude.link_a, exclude.link_b): exclude.reason for exclude in geometry.excludes}
    assert (excludes["left", "right"], excludes["upper", "left"]) == ("Source", "Source")
    assert ("base", "lower") not in excludes


def test_fingers_that_overlap_touch_only_without_the_srdf():
    """The two fingers of the URDF have one place."""
    assert [
        pair for pair in geometry_of(robot()).touching if {pair.link_a, pair.link_b} == {"left", "right"}
    ] == []
    bare = geometry_of(urdf_robot(URDF, plan_of(**KEYS)))
    pairs = {frozenset((exclude.link_a, exclude.link_b)) for exclude in (*bare.touching, *bare.excludes)}
    assert frozenset(("left", "right")) in pairs


def test_the_user_lets_all_pairs_collide():
    geometry = geometry_of(robot(), self="all")
    assert [exclude for exclude in geometry.excludes if exclude.reason == "Source"] == []


def test_robot_json_has_the_semantics_and_is_read_back(tmp_path):
    built(tmp_path)
    table = json.loads((tmp_path / "robot.json").read_text())
    assert [group["name"] for group in table["semantics"]["groups"]] == ["arm", "hand", "all"]
    assert [check for check in srdf_checks(tmp_path) if not check.passed] == []


@pytest.mark.parametrize(("old", "new", "element"), [
    ('<group name="hand">', '<group name="claw">', 'group "hand"'),
    ('<joint name="right_slide"/>', '<joint name="elbow"/>', 'group "hand"'),
    ('group="hand" parent_group="arm"', 'group="all" parent_group="arm"', 'end_effector "gripper"'),
    ('<end_effector name="gripper"', '<end_effector name="claw"', 'end_effector "gripper"'),
    ('parent_frame="table"', 'parent_frame="floor"', 'virtual_joint "mount"'),
    ('link2="right" reason="User"', 'link2="right" reason="Never"', 'disable_collisions "left" "right"'),
])  # fmt: skip
def test_what_differs_from_the_source_is_found(tmp_path, old, new, element):
    built(tmp_path)
    path = tmp_path / "robot.srdf"
    text = path.read_text()
    assert old in text, text
    path.write_text(text.replace(old, new, 1))
    assert element in [diagnostic.element for check in srdf_checks(tmp_path) for diagnostic in check.findings]


def test_moveits_package_has_the_groups_of_the_source(tmp_path):
    plan = plan_of(**(KEYS | {"export": {"ros2": {}}}))
    made = robot(plan=plan)
    package = packed(export(made, geometry_of(made), plan).files, tmp_path)
    (path,) = (moveit_of(package).folder / "config").glob("*.srdf")
    semantics = Srdf(path.read_bytes(), package.plain)
    assert (semantics.problems(), semantics.groups) == ([], JOINTS)
    assert [end_effector.get("name") for end_effector in semantics.root.iter("end_effector")] == ["gripper"]


def test_passive_joints_have_no_actuator_unless_they_are_named(tmp_path):
    text = SRDF.replace("</robot>", '<passive_joint name="right_slide"/></robot>')
    written = built(tmp_path, text)
    assert [passive_joint.get("name") for passive_joint in written.root.iter("passive_joint")] == [
        "right_slide"
    ]
    actuators = json.loads((tmp_path / "robot.json").read_text())["actuators"]
    assert [actuator["dof"] for actuator in actuators] == ["shoulder", "elbow", "left_slide"]
    named = built(tmp_path, text, actuators={"*": "position", "right_slide": "position"})
    assert not list(named.root.iter("passive_joint"))


def test_a_passive_joint_that_a_glob_matches_is_reported(tmp_path):
    text = SRDF.replace("</robot>", '<passive_joint name="right_slide"/></robot>')
    plan = plan_of(**KEYS)
    made = robot(text, plan)
    log = write(made, tmp_path, plan, geometry_of(made)).diagnostics
    assert [problem for problem in log if problem.code == "I-ACTUATOR" and "right_slide" in problem.message]


def test_the_pose_is_a_keyframe_of_the_mjcf(tmp_path):
    built(tmp_path)
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "ready")
    assert {name: model.key_qpos[number][model.joint(name).qposadr[0]] for name in READY} == READY
    assert np.isfinite(model.key_ctrl[number]).all()
