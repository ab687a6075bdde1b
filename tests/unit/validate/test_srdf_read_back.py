"""The SRDF is held against the robot: what only some robots have, and what a user may add by hand."""

import pytest

from linkwright.stages.robot.model.robot import Frame, Limits, frozen
from tests.support.building import plan_of, write
from tests.support.checked import srdf_checks
from tests.support.faults.checks import SRDF_OF_A_USER
from tests.support.robots import at, joint, robot_with
from tests.support.touching import box, geometry_of

MOTOR = {"type": "motor"}


def robot(**more):
    """A shoulder, an elbow and a ball, with a frame at the end."""
    limits = {name: Limits(-1, 1) for name in ("shoulder", "elbow")}
    rows = [
        joint("revolute", "base", "upper", name="shoulder", place=at(0.3, 0, 0), limits=limits),
        joint("revolute", "upper", "lower", name="elbow", place=at(0.3, 0, 0), limits=limits),
        joint("ball", "lower", "hand", [(0.8, 0.6, 0.0, 0.0)], name="wrist", place=at(0.3, 0, 0)),
    ]
    shapes = {name: (box(0.05, 0.05, 0.05),) for name in ("base", "upper", "lower", "hand")}
    tool = Frame("tool", "hand", frozen(at(0, 0, 0.1)), "Tool")
    return robot_with(rows, frames=[tool], shapes=shapes, **more)


def findings(folder, old="", new="", **keys):
    """Elements and attributes that the checks name, after a change to the text."""
    own = robot()
    write(
        own,
        folder,
        plan_of(**{"export": {"urdf": {}}, "contact": {"self": "auto"}, **keys}),
        geometry_of(own),
    )
    path = folder / "robot.srdf"
    text = path.read_text()
    assert not old or old in text, text
    path.write_text(text.replace(old, new, 1) if old else text)
    return problems_of(folder)


def problems_of(folder):
    return [
        (finding.element, finding.attribute) for check in srdf_checks(folder) for finding in check.findings
    ]


ELBOW = {"actuators": {"shoulder": MOTOR, "wrist": "none", "elbow": "none"}}


def test_joints_that_nothing_drives_must_be_passive(tmp_path):
    assert findings(tmp_path, **ELBOW) == []
    gone = findings(tmp_path, '<passive_joint name="elbow"/>', "", **ELBOW)
    assert gone == [('passive_joint "elbow"', "name")]
    more = findings(tmp_path, "</robot>", '<passive_joint name="tool_fixed"/></robot>', **ELBOW)
    assert more == [('passive_joint "tool_fixed"', "name")]


def test_turned_ball_is_found_by_its_joints(tmp_path):
    turned = findings(tmp_path, '<joint name="wrist_y" value="0"/>', '<joint name="wrist_y" value="0.1"/>')
    assert turned
    assert {attribute.partition("_")[0] for _, attribute in turned} == {"joint wrist"}


OWN = """
<group name="mine"><chain base_link="upper" tip_link="hand"/></group>
<group name="links"><link name="lower"/><group name="mine"/></group>
<group_state name="ready" group="links">
  <joint name="elbow" value="0.9"/><joint name="wrist_x" value="2"/>
  <joint name="wrist_y" value="0"/><joint name="wrist_z" value="0"/>
</group_state>
<enable_collisions link1="base" link2="hand"/>
</robot>"""


def test_end_effector_needs_no_parent_group(tmp_path):
    """It is optional in the format, and the SRDFs of legged robots have none."""
    own = '<end_effector name="foot" group="all" parent_link="base"/></robot>'
    assert ('end_effector "foot"', "parent_group") not in findings(tmp_path, "</robot>", own)
    corrected = own.replace("/></robot>", ' parent_group="alll"/></robot>')
    assert ('end_effector "foot"', "parent_group") in findings(tmp_path, "</robot>", corrected)


def test_groups_of_groups_are_read_once(tmp_path):
    """Each group has the next twice: to read each as often as it is named would take 2⁶⁰ steps."""
    inner = "".join(
        f'<group name="g{n}"><group name="g{n + 1}"/><group name="g{n + 1}"/></group>' for n in range(60)
    )
    last = '<group name="g60"><joint name="shoulder"/></group></robot>'
    assert findings(tmp_path, "</robot>", inner + last) == []


def test_groups_and_poses_of_the_users_own_are_no_fault(tmp_path):
    assert findings(tmp_path, "</robot>", OWN) == []


@pytest.mark.parametrize("fault", SRDF_OF_A_USER, ids=lambda fault: fault.kind)
def test_what_a_user_adds_must_fit_the_robot(fault, tmp_path):
    findings(tmp_path, "</robot>", OWN)
    (element,), (attribute,) = fault.change(tmp_path, "robot").elements, fault.attributes
    assert (element, attribute) in problems_of(tmp_path)


def test_link_of_the_users_own_xml_is_known(tmp_path):
    held = '<joint name="held" type="fixed"><parent link="hand"/><child link="camera"/></joint>'
    xml = f'<link name="camera"/>{held}'
    own = {"elements": {"camera": {"into": {"tag": "robot"}, "xml": xml, "formats": ["urdf"]}}}
    added = '<group name="seen"><chain base_link="base" tip_link="camera"/></group></robot>'
    assert findings(tmp_path, "</robot>", added, **own) == []
    assert findings(tmp_path, "</robot>", added) == [('group "seen"', "chain tip_link")]


def test_pair_that_touches_at_home_is_not_apart(tmp_path):
    limits = {name: Limits(-1, 1) for name in ("shoulder", "elbow")}
    rows = [
        joint("revolute", "base", "upper", name="shoulder", place=at(0.3, 0, 0), limits=limits),
        joint("revolute", "upper", "lower", name="elbow", place=at(-0.3, 0, 0), limits=limits),
    ]
    shapes = {name: (box(0.05, 0.05, 0.05),) for name in ("base", "upper", "lower")}
    own = robot_with(rows, shapes=shapes)
    write(own, tmp_path, plan_of(export={"urdf": {}}, contact={"self": "auto"}), geometry_of(own))
    path = tmp_path / "robot.srdf"
    assert all(check.passed for check in srdf_checks(tmp_path))
    added = '<disable_collisions link1="base" link2="lower" reason="Never"/></robot>'
    path.write_text(path.read_text().replace("</robot>", added))
    (diagnostic,) = [diagnostic for check in srdf_checks(tmp_path) for diagnostic in check.findings]
    assert (diagnostic.element, diagnostic.attribute) == ('disable_collisions "base" "lower"', "reason")
    assert "touch at home" in diagnostic.message
