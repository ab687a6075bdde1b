"""Every element and attribute of a URDF: carried over to what we write, or named.

What urdfdom reads, what its formats before and after it have, and what is written into URDFs for Gazebo,
ROS 2, MuJoCo, Drake and RaiSim.
"""

import re
from dataclasses import replace

import mujoco
import pytest
from lxml import etree

from linkwright.stages.robot.codec import encode_robot
from tests.support.building import plan_of, write
from tests.support.checked import failures
from tests.support.reported import only, reports
from tests.support.urdfs import urdf_robot

BODY = """<inertial><origin xyz="0 0 .1" rpy="0 0 0"/><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"""
SHAPE = '<origin xyz="0 0 0" rpy="0 0 0"/><geometry><{shape}/></geometry>'


def shape(role, solid):
    return f"<{role}>{SHAPE.format(shape=solid)}</{role}>"


SOLIDS = ('box size="1 1 1"', *(f'{kind} radius="1" length="1"' for kind in ("cylinder", "capsule")),
          'sphere radius="1"')  # fmt: skip
BASE = f"""<robot name="r" version="1.0" xmlns:drake="http://drake">
<material name="red"><color rgba="1 0 0 1"/></material>
<link name="base">{BODY}{"".join(shape("visual", solid) for solid in SOLIDS)}
  <visual><geometry><mesh filename="a.stl" scale="1 1 1"/></geometry>
    <material name="red"/></visual>{shape("collision", SOLIDS[0])}</link>
<link name="arm">{BODY}</link><link name="hand">{BODY}</link><link name="frame"/>
<link name="lid">{BODY}</link>
<joint name="j" type="revolute"><origin xyz="0 0 1" rpy="0 0 0"/><parent link="base"/><child link="arm"/>
  <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="2" velocity="3"/>
  <dynamics damping="1" friction="1"/></joint>
<joint name="k" type="continuous"><parent link="arm"/><child link="hand"/>
  <mimic joint="j" multiplier="1" offset="0"/></joint>
<joint name="f" type="fixed"><origin xyz="0 0 1"/><parent link="arm"/><child link="frame"/></joint>
<joint name="g" type="continuous"><parent link="base"/><child link="lid"/></joint>
<transmission name="t"><type>ti/Simple</type>
  <joint name="j"><hardwareInterface>Effort</hardwareInterface></joint>
  <actuator name="m"><mechanicalReduction>50</mechanicalReduction></actuator></transmission>
<ros2_control name="s" type="system"><hardware><plugin>p</plugin></hardware>
  <joint name="j"><command_interface name="position"/><state_interface name="velocity"/></joint>
  <sensor name="imu"><state_interface name="x"/></sensor></ros2_control></robot>"""

SAID = [line.strip() for line in """
robot name other | material[1] name blue | material/color rgba 0 1 0 1 | material texture/filename wood.png
link[2] name other | link[2] type arm | link/inertial/origin xyz 0 0 .2 | link/inertial/origin rpy 1 0 0
link/inertial/origin quat_xyzw 1 0 0 1 | link/inertial/mass value 2 | link/inertial/inertia ixx 1.1
link/inertial/inertia ixy .1 | link/inertial/inertia ixz .1 | link/inertial/inertia iyy 1.1
link/inertial/inertia iyz .1 | link/inertial/inertia izz 1.1 | link/visual name look | link/visual group g
link/visual/origin xyz 0 0 .2 | link/visual/origin rpy 1 0 0 | link/visual/geometry/box size 1 2 3
link/visual/geometry/cylinder radius 2 | link/visual/geometry/cylinder length 2
link/visual/geometry/capsule radius 2 | link/visual/geometry/capsule length 2
link/visual/geometry/sphere radius 2 | link/visual/geometry/mesh filename b.stl
link/visual/geometry/mesh scale 1 2 3 | link/visual/material name white | link/collision name touch
link/collision group g | link/collision/origin xyz 0 0 .2 | link/collision/origin rpy 1 0 0
link/collision/geometry/box size 1 2 3 | link contact/lateral_friction/value 1
link self_collision_checking/collision 1 | joint name other | joint type prismatic
joint dont_collapse true | joint/origin xyz 0 0 2 | joint/origin rpy 1 0 0 | joint[2]/parent link base
joint/axis xyz 0 1 0 | joint/limit lower -2 | joint/limit upper 2 | joint/limit effort 5
joint/limit velocity 5 | joint/limit acceleration 5 | joint/limit deceleration 5 | joint/limit jerk 5
joint/dynamics damping 2 | joint/dynamics friction 2 | joint/dynamics rotorInertia 2
joint/dynamics rotor_inertia 2 | joint/dynamics armature 2 | joint/dynamics spring_stiffness 2
joint safety_controller/k_velocity 1 | joint calibration/rising 1 | joint drake:spring/value 1
joint[2]/mimic joint g | joint[2]/mimic multiplier 2 | joint[2]/mimic offset 2 | transmission name other
transmission/joint name k | transmission/actuator name other | transmission/actuator mechanicalReduction 7
transmission/actuator drake:rotor_inertia/value 2 | ros2_control name other | ros2_control type actuator
ros2_control/hardware param x | ros2_control/joint name k | ros2_control gpio/name x
ros2_control/joint/command_interface name effort | robot gazebo/reference arm | robot sensor/name eye
robot mujoco/compiler/balanceinertia true | robot mujoco/option/timestep .1 | robot drake:joint/name x
link drake:note x | joint colour red""".strip().replace("\n", "|").split("|")]  # fmt: skip
"""What a URDF may say besides: where, the attribute (or the element to add, down to its attribute), and a
value."""

WITHOUT_MEANING = {"robot name other"}
"""The robot is called as its file is."""


def changed(line):
    """The URDF that says this too."""
    where, action, *value = line.split(" ")
    tree = etree.fromstring(BASE)
    path = where.removeprefix("robot").removeprefix("/")
    node = tree.find(path) if path else tree
    *below, name = action.split("/")
    if (not below and name.startswith("drake:")) or name in ("mechanicalReduction", "param"):
        below, name = [name], ""
    for step in below:
        step = step.replace("drake:", "{http://drake}")
        entry = node.find(step)
        node = etree.SubElement(node, step) if entry is None else entry
    if name == "name" and not below and where in ("link[2]", "joint"):  # wherever it is named
        return BASE.replace(f'"{node.get("name")}"', f'"{value[0]}"').encode()
    if name:
        node.set(name, " ".join(value))
    else:
        node.text = " ".join(value)
    return etree.tostring(tree)


def outcome(text):
    """Returns the messages on what was left out, and the robot without them."""
    robot = urdf_robot(text)
    codes = ("I-URDF-LEFT", "W-URDF-UNKNOWN", "W-URDF-MIMIC", "W-URDF-MATERIAL", "I-URDF-TEXTURE")
    messages = {diagnostic.message for diagnostic in robot.diagnostics if diagnostic.code in codes}
    return messages, encode_robot(replace(robot, diagnostics=()))


@pytest.fixture(scope="module")
def base():
    return outcome(BASE.encode())


@pytest.mark.parametrize("line", [line for line in SAID if line not in WITHOUT_MEANING])
def test_a_line_of_a_urdf_is_carried_over_or_named(line, base):
    messages, robot = outcome(changed(line))
    said = re.findall(r"[\w.]+", line.partition(" ")[2])
    words = {word for message in messages - base[0] for word in re.findall(r"[\w.]+", message)}
    assert words & set(said) or robot != base[1]


def test_a_plain_urdf_loses_nothing(base):
    assert base[0] == set()


def test_drives_of_joints_are_written_back(tmp_path):
    assert failures(tmp_path, urdf_robot(BASE)) == []
    trees = etree.parse(tmp_path / "robot.urdf").getroot(), etree.fromstring(BASE)
    for kind in ("transmission", "ros2_control"):
        ours, theirs = (
            [(node.tag, node.attrib, (node.text or "").strip()) for node in tree.find(kind).iter()]
            for tree in trees
        )
        assert ours == theirs


def test_drives_of_a_joint_follow_its_name(tmp_path):
    text = BASE.replace(
        "</ros2_control>",
        """<joint name="k"><param name="mimic">j</param></joint><joint name="gone"/>
        <transmission name="u"><joint name="gone"/></transmission></ros2_control>
        <transmission name="v"><joint name="gone"/><joint name="j"/></transmission>""",
    )
    robot = urdf_robot(text, plan_of(names={"joints": {"j": "elbow"}}))
    root = etree.fromstring(write(robot, tmp_path).files["robot.urdf"])
    assert [joint.get("name") for joint in root.findall("transmission/joint")] == ["elbow"]
    assert [joint.get("name") for joint in root.findall("ros2_control/joint")] == ["elbow", "k"]
    assert root.findtext("ros2_control/joint/param") == "elbow"
    assert root.find("ros2_control/transmission") is None
    assert reports(robot, "W-URDF-CONTROL") == [("W-URDF-CONTROL", "gone")] * 2


@pytest.mark.parametrize(
    ("said", "armature"),
    [
        ('<dynamics rotorInertia="0.25"/>', 0.25),
        ('<dynamics rotor_inertia="0.5" damping="1"/>', 0.5),
        ('<dynamics armature="0.125"/>', 0.125),
        ("", 2e-3 * 50**2),
    ],
)
def test_the_inertia_of_a_rotor_is_the_armature(said, armature, tmp_path):
    drive = '<drake:rotor_inertia value="2e-3"/><drake:gear_ratio value="50"/></actuator>'
    text = BASE.replace('<dynamics damping="1" friction="1"/>', said).replace("</actuator>", drive)
    robot = urdf_robot(text)
    assert [dof.dynamics.armature for dof in robot.dofs if dof.name == "j"] == [armature]
    assert only(write(robot, tmp_path), "I-URDF-ARMATURE").message.endswith(": j")
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml")).joint("j").armature[0] == armature
    assert said or failures(tmp_path, robot) == []
