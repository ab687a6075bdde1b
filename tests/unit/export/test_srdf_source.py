"""The SRDF of a URDF source in what is built: groups, poses and pairs as they were, and checked."""

import json

import numpy as np
import pytest
from lxml import etree

from tests.support.building import plan_of, write
from tests.support.checked import srdf_checks
from tests.support.exports import compiled, messages_of
from tests.support.pinocchio import pin
from tests.support.ros2 import moveit_of, packed
from tests.support.srdf import InPinocchio, Srdf
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

JOINTS = {"arm": {"shoulder", "elbow"}, "hand": {"left_slide", "right_slide"}}
JOINTS["all"] = JOINTS["arm"] | JOINTS["hand"]
READY = {"shoulder": 0.5, "elbow": -0.25, "left_slide": 0.125, "right_slide": 0.25}
"""What the SRDF says."""

KEYS = {"export": {"urdf": {}, "mjcf": {}}, "contact": {"self": "auto"}, "actuators": {"*": "position"}}


def robot(text=SRDF, plan=None):
    return urdf_robot(URDF, plan or plan_of(**KEYS), srdf=text)


def outcome_of(folder, text=SRDF, **keys):
    plan = plan_of(**(KEYS | keys))
    made = robot(text, plan)
    return write(made, folder, plan, geometry_of(made))


def built(folder, text=SRDF, **keys):
    files = outcome_of(folder, text, **keys).files
    return Srdf(files["robot.srdf"], files["robot.urdf"])


def test_groups_states_base_and_pairs_are_those_of_the_source(tmp_path):
    written, source = built(tmp_path), Srdf(SRDF.encode(), URDF.encode())
    assert (written.problems(), written.groups) == ([], JOINTS)
    for group, joints in JOINTS.items():
        assert written.states(group)["ready"] == {name: READY[name] for name in joints}
    for tag in ("virtual_joint", "end_effector"):
        ours, theirs = ([dict(node.attrib) for node in srdf.root.iter(tag)] for srdf in (written, source))
        assert ours == theirs
    chains = [dict(chain.attrib) for chain in written.root.iter("chain")]
    assert chains == [{"base_link": "base", "tip_link": "tool"}]
    reasons = {frozenset(pair): reason for pair, reason in written.disabled.items()}
    for pair, reason in (("left right", "User"), ("base lower", "Never"), ("upper left", "Default")):
        assert reasons[frozenset(pair.split())] == reason
    table = json.loads((tmp_path / "robot.json").read_text())
    assert [group["name"] for group in table["semantics"]["groups"]] == ["arm", "hand", "all"]
    assert [check for check in srdf_checks(tmp_path) if not check.passed] == []


def test_pinocchio_reads_the_same_pose_and_pairs(tmp_path):
    built(tmp_path)
    model = pin.buildModelFromXML(URDF)
    pin.loadReferenceConfigurationsFromXML(model, SRDF)
    ready = model.referenceConfigurations["ready"]
    expected = {name: ready[model.joints[model.getJointId(name)].idx_q] for name in READY}
    reader = InPinocchio(tmp_path)
    assert reader.states()["ready"] == pytest.approx(expected, abs=1e-12)
    nodes = etree.fromstring(SRDF).iter("disable_collisions")
    assert not {frozenset((node.get("link1"), node.get("link2"))) for node in nodes} & set(reader.active())


def test_pairs_of_the_source_do_not_collide_unless_never():
    geometry = geometry_of(robot())
    excludes = {(exclude.link_a, exclude.link_b): exclude.reason for exclude in geometry.excludes}
    assert (excludes["left", "right"], excludes["upper", "left"]) == ("Source", "Source")
    assert ("base", "lower") not in excludes
    everything = geometry_of(robot(), self="all")
    assert "Source" not in {exclude.reason for exclude in everything.excludes}, "the user lets all collide"


def test_fingers_that_overlap_touch_only_without_the_srdf():
    """The two fingers of the URDF have one place."""
    fingers = frozenset(("left", "right"))
    assert fingers not in {frozenset((pair.link_a, pair.link_b)) for pair in geometry_of(robot()).touching}
    bare = geometry_of(urdf_robot(URDF, plan_of(**KEYS)))
    assert fingers in {frozenset((pair.link_a, pair.link_b)) for pair in (*bare.touching, *bare.excludes)}


@pytest.mark.parametrize(("old", "new", "element"), [
    ('<group name="hand">', '<group name="claw">', 'group "hand"'),
    ('<joint name="right_slide"/>', '<joint name="elbow"/>', 'group "hand"'),
    ('group="hand" parent_group="arm"', 'group="all" parent_group="arm"', 'end_effector "gripper"'),
    ('parent_link="tool"', 'parent_link="lower"', 'end_effector "gripper"'),
    ('<end_effector name="gripper"', '<end_effector name="claw"', 'end_effector "gripper"'),
    ('parent_frame="table"', 'parent_frame="floor"', 'virtual_joint "mount"'),
    ('link2="right" reason="User"', 'link2="right" reason="Never"', 'disable_collisions "left" "right"'),
])  # fmt: skip
def test_difference_from_the_source_is_found(tmp_path, old, new, element):
    built(tmp_path)
    path = tmp_path / "robot.srdf"
    text = path.read_text()
    assert old in text, text
    path.write_text(text.replace(old, new, 1))
    assert element in [diagnostic.element for check in srdf_checks(tmp_path) for diagnostic in check.findings]


def test_moveits_package_has_the_groups_of_the_source(tmp_path):
    package = packed(outcome_of(tmp_path / "files", export={"ros2": {}}).files, tmp_path)
    (path,) = (moveit_of(package).folder / "config").glob("*.srdf")
    semantics = Srdf(path.read_bytes(), package.plain)
    assert (semantics.problems(), semantics.groups) == ([], JOINTS)
    assert [effector.get("name") for effector in semantics.root.iter("end_effector")] == ["gripper"]


def test_passive_joints_have_no_actuator_unless_they_are_named(tmp_path):
    text = SRDF.replace("</robot>", '<passive_joint name="right_slide"/></robot>')
    outcome = outcome_of(tmp_path, text)
    nodes = etree.fromstring(outcome.files["robot.srdf"]).iter("passive_joint")
    assert [node.get("name") for node in nodes] == ["right_slide"]
    assert [message for message in messages_of(outcome, "I-ACTUATOR") if "right_slide" in message]
    actuators = json.loads(outcome.files["robot.json"])["actuators"]
    assert [actuator["dof"] for actuator in actuators] == ["shoulder", "elbow", "left_slide"]
    named = built(tmp_path, text, actuators={"*": "position", "right_slide": "position"})
    assert not list(named.root.iter("passive_joint"))


def test_pose_is_a_keyframe_of_the_mjcf(tmp_path):
    model = compiled(outcome_of(tmp_path))
    key = model.key("ready")
    assert {name: key.qpos[model.joint(name).qposadr[0]] for name in READY} == READY
    assert np.isfinite(key.ctrl).all()
