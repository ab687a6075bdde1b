"""Checks of a bare URDF or MJCF: each kind of fault is found with its element and attribute, and no other."""

import struct
from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.robot.check import Check
from linkwright.stages.validate.bare.run import check_bare
from tests.support.other_robots import FILES, is_here


def box_stl(x: float, y: float, z: float) -> bytes:
    """A box around its origin, of these lengths, as a binary STL."""
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * (x / 2, y / 2, z / 2)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [(a, b, c) for a, b, c, _ in sides] + [(a, c, d) for a, _, c, d in sides]
    rows = [struct.pack("<12fH", 0, 0, 0, *corners[list(face)].ravel(), 0) for face in faces]
    return b"\0" * 80 + struct.pack("<I", len(rows)) + b"".join(rows)


LINK = """<link name="{name}">
  <inertial><origin xyz="0 0 0.1"/><mass value="1"/>
    <inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0009"/></inertial>
  <visual><origin xyz="0 0 0.1"/><geometry><mesh filename="{name}.stl"/></geometry></visual>
  <collision><origin xyz="0 0 0.1"/><geometry><box size="0.07 0.07 0.2"/></geometry></collision>
</link>
"""

JOINT = """<joint name="{name}" type="revolute">
  <origin xyz="0 0 0.25"/><parent link="{parent}"/><child link="{child}"/><axis xyz="0 1 0"/>
  <limit lower="-1.5" upper="1.5" effort="10" velocity="3"/><dynamics damping="0.1" friction="0.01"/>
</joint>
"""

URDF = (
    '<robot name="arm">\n'
    + "".join(LINK.format(name=name) for name in ("base", "upper", "lower"))
    + JOINT.format(name="shoulder", parent="base", child="upper")
    + JOINT.format(name="elbow", parent="upper", child="lower").replace(
        "</joint>", '  <mimic joint="shoulder" multiplier="1"/>\n</joint>'
    )
    + "</robot>\n"
)

MJCF = """<mujoco model="arm">
  <compiler angle="radian"/>
  <asset><mesh file="base.stl"/><mesh file="upper.stl"/><mesh file="lower.stl"/></asset>
  <default>
    <joint damping="0.1" frictionloss="0.01" armature="0.01"/>
    <default class="visual"><geom type="mesh" contype="0" conaffinity="0" density="0" group="2"/></default>
    <default class="collision"><geom type="box" size="0.035 0.035 0.1" density="0"/></default>
  </default>
  <worldbody>
    <body name="base">
      <inertial pos="0 0 0.1" mass="1" diaginertia="0.004 0.004 0.0009"/>
      <geom class="visual" mesh="base" pos="0 0 0.1"/><geom class="collision" pos="0 0 0.1"/>
      <body name="upper" pos="0 0 0.25" quat="1 0 0 0">
        <joint name="shoulder" axis="0 1 0" range="-1.5 1.5"/>
        <inertial pos="0 0 0.1" mass="1" diaginertia="0.004 0.004 0.0009"/>
        <geom class="visual" mesh="upper" pos="0 0 0.1"/>
        <geom name="upper" class="collision" pos="0 0 0.1"/>
        <site name="upper_end" pos="0 0 0.25"/>
        <body name="lower" pos="0 0 0.25">
          <joint name="elbow" axis="0 1 0" range="-1.5 1.5"/>
          <inertial pos="0 0 0.1" mass="1" diaginertia="0.004 0.004 0.0009"/>
          <geom class="visual" mesh="lower" pos="0 0 0.1"/><geom class="collision" pos="0 0 0.1"/>
          <site name="lower_start"/>
        </body>
      </body>
    </body>
    <body name="ball" pos="0 1 0.3">
      <freejoint name="ball"/><geom name="ball" size="0.05" mass="0.5"/>
    </body>
  </worldbody>
  <equality>
    <joint joint1="elbow" joint2="shoulder" polycoef="0 1 0 0 0"/>
    <connect name="loop" site1="upper_end" site2="lower_start"/>
  </equality>
  <actuator><position name="shoulder" joint="shoulder" kp="20" ctrlrange="-1.5 1.5"/></actuator>
  <keyframe><key name="home" qpos="0.1 0.1 0 1 0.3 1 0 0 0" ctrl="0.1"/></keyframe>
</mujoco>
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("base", "upper", "lower"):
        (tmp_path / f"{name}.stl").write_bytes(box_stl(0.07, 0.07, 0.2))
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "arm.xml").write_text(MJCF)
    return tmp_path


def found(checks: tuple[Check, ...]) -> set[tuple[str, str, str]]:
    return {
        (check.code, one.element, one.attribute)
        for check in checks
        if not check.passed
        for one in check.findings
    }


def planted(path: Path, old: str, new: str) -> None:
    """Replaces the last place of a text: that of the last link or joint."""
    before, middle, after = path.read_text().rpartition(old)
    assert middle
    path.write_text(before + new + after)


def test_good_files_pass(folder):
    assert [one for one in check_bare(folder) if not one.passed] == []
    assert {one.code for one in check_bare(folder)} >= {
        *("C-TREE", "C-MIMIC", "C-DIRECTION", "C-LIMIT", "C-SOLID", "C-UNITS", "C-KEYS", "C-PLAUSIBLE"),
        *("C-XML", "C-NAME", "C-REFERENCE", "C-NUMBER", "C-ASSET", "C-COMPILE", "C-START", "C-CLOSED"),
        *("C-TRIAL", "C-TOGETHER"),
    }


OF_URDF = {
    "broken": ("</robot>", "", "C-XML", "XML", ""),
    "missing mesh": ("lower.stl", "bottom.stl", "C-ASSET", 'mesh of visual of link "lower"', "filename"),
    "package": ("lower.stl", "package://x/l.stl", "C-PATH", 'mesh of visual of link "lower"', "filename"),
    "same name": ('<joint name="elbow"', '<joint name="shoulder"', "C-NAME", 'joint "shoulder"', "name"),
    "no such parent": (
        'parent link="upper"',
        'parent link="uper"',
        "C-REFERENCE",
        'parent of joint "elbow"',
        "link",
    ),
    "no such child": (
        'child link="lower"',
        'child link="lowr"',
        "C-REFERENCE",
        'child of joint "elbow"',
        "link",
    ),
    "two roots": ("</robot>", '<link name="lost"/></robot>', "C-TREE", 'link "lost"', "name"),
    "cycle": ('parent link="upper"', 'parent link="lower"', "C-TREE", 'joint "elbow"', "child"),
    "mimic itself": (
        'mimic joint="shoulder"',
        'mimic joint="elbow"',
        "C-MIMIC",
        'mimic of joint "elbow"',
        "joint",
    ),
    "mimic of nothing": (
        'mimic joint="shoulder"',
        'mimic joint="hip"',
        "C-REFERENCE",
        'mimic of joint "elbow"',
        "joint",
    ),
    "swapped limits": (
        'lower="-1.5" upper="1.5"',
        'lower="1.5" upper="-1.5"',
        "C-LIMIT",
        'limit of joint "elbow"',
        "lower",
    ),
    "no limits": (
        '<limit lower="-1.5" upper="1.5" effort="10" velocity="3"/>',
        "",
        "C-LIMIT",
        'joint "elbow"',
        "limit",
    ),
    "degrees": ('upper="1.5"', 'upper="90"', "C-PLAUSIBLE", 'limit of joint "elbow"', "upper"),
    "no effort": ('effort="10"', 'effort="0"', "C-PLAUSIBLE", 'limit of joint "elbow"', "effort"),
    "negative effort": ('effort="10"', 'effort="-10"', "C-LIMIT", 'limit of joint "elbow"', "effort"),
    "negative velocity": ('velocity="3"', 'velocity="-3"', "C-LIMIT", 'limit of joint "elbow"', "velocity"),
    "negative damping": (
        'damping="0.1"',
        'damping="-0.1"',
        "C-LIMIT",
        'dynamics of joint "elbow"',
        "damping",
    ),
    "no axis": ('axis xyz="0 1 0"', 'axis xyz="0 0 0"', "C-DIRECTION", 'axis of joint "elbow"', "xyz"),
    "long axis": ('axis xyz="0 1 0"', 'axis xyz="0 2 0"', "C-PLAUSIBLE", 'axis of joint "elbow"', "xyz"),
    "nan": ('axis xyz="0 1 0"', 'axis xyz="0 nan 0"', "C-NUMBER", 'axis of joint "elbow"', "xyz"),
    "no mass": ('mass value="1"', 'mass value="0"', "C-SOLID", 'mass of link "lower"', "value"),
    "negative mass": ('mass value="1"', 'mass value="-1"', "C-SOLID", 'mass of link "lower"', "value"),
    "grams": ('mass value="1"', 'mass value="1000"', "C-INERTIAL", 'mass of link "lower"', "value"),
    "negative moment": ('ixx="0.004"', 'ixx="-0.004"', "C-SOLID", 'inertia of link "lower"', "ixx"),
    "not definite": ('ixy="0"', 'ixy="0.005"', "C-SOLID", 'inertia of link "lower"', "ixy"),
    "triangle": ('izz="0.0009"', 'izz="0.009"', "C-SOLID", 'inertia of link "lower"', "izz"),
    "kg mm²": (
        'ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0009"',
        'ixx="4000" ixy="0" ixz="0" iyy="4000" iyz="0" izz="900"',
        "C-INERTIAL",
        'inertia of link "lower"',
        "ixx",
    ),
    "center in mm": (
        '<inertial><origin xyz="0 0 0.1"/>',
        '<inertial><origin xyz="0 0 100"/>',
        "C-INERTIAL",
        'origin of link "lower"',
        "xyz",
    ),
    "center outside": (
        '<inertial><origin xyz="0 0 0.1"/>',
        '<inertial><origin xyz="0 0 0.5"/>',
        "C-INERTIAL",
        'origin of link "lower"',
        "xyz",
    ),
    "mesh in mm": (
        'filename="lower.stl"',
        'filename="lower.stl" scale="1000 1000 1000"',
        "C-UNITS",
        'mesh of visual of link "lower"',
        "scale",
    ),
    "collider moved": (
        '<collision><origin xyz="0 0 0.1"/>',
        '<collision><origin xyz="0 0 0.6"/>',
        "C-COLLIDER",
        'origin of collision of link "lower"',
        "xyz",
    ),
    "light beside heavy": (
        'mass value="1"',
        'mass value="0.0005"',
        "C-MASS-RATIO",
        'mass of link "lower"',
        "value",
    ),
    "misspelled": ('upper="1.5"', 'uper="1.5"', "C-XML-KNOWN", 'limit of joint "elbow"', "uper"),
}


@pytest.mark.parametrize("kind", OF_URDF)
def test_a_fault_of_a_urdf_is_found(folder, kind):
    old, new, *expected = OF_URDF[kind]
    planted(folder / "arm.urdf", old, new)
    checks = check_bare(folder / "arm.urdf")
    assert tuple(expected) in found(checks)
    assert all(one.message for check in checks for one in check.findings)


OF_MJCF = {
    "broken": ("</mujoco>", "", "C-XML", "XML", ""),
    "missing mesh": ('file="lower.stl"', 'name="lower" file="x.stl"', "C-ASSET", 'mesh "lower"', "file"),
    "same name": ('joint name="elbow"', 'joint name="shoulder"', "C-NAME", 'joint "shoulder"', "name"),
    "no such joint": ('joint="shoulder" kp', 'joint="hip" kp', "C-REFERENCE", 'position "shoulder"', "joint"),
    "no such body": ('site2="lower_start"', 'body2="nobody"', "C-REFERENCE", 'connect "loop"', "body2"),
    "swapped range": (
        'name="elbow" axis="0 1 0" range="-1.5 1.5"',
        'name="elbow" axis="0 1 0" range="1.5 -1.5"',
        "C-LIMIT",
        'joint "elbow"',
        "range",
    ),
    "degrees": (
        'name="elbow" axis="0 1 0" range="-1.5 1.5"',
        'name="elbow" axis="0 1 0" range="-90 90"',
        "C-PLAUSIBLE",
        'joint "elbow"',
        "range",
    ),
    "radians as degrees": ('angle="radian"', 'angle="degree"', "C-PLAUSIBLE", 'joint "shoulder"', "range"),
    "no axis": (
        'name="elbow" axis="0 1 0"',
        'name="elbow" axis="0 0 0"',
        "C-DIRECTION",
        'joint "elbow"',
        "axis",
    ),
    "no rotation": ('quat="1 0 0 0"', 'quat="0 0 0 0"', "C-DIRECTION", 'body "upper"', "quat"),
    "nan": ('quat="1 0 0 0"', 'quat="1 nan 0 0"', "C-NUMBER", 'body "upper"', "quat"),
    "negative mass": ('mass="1"', 'mass="-1"', "C-SOLID", 'inertial of body "lower"', "mass"),
    "no mass": ('mass="1"', 'mass="0"', "C-SOLID", 'inertial of body "lower"', "mass"),
    "triangle": (
        'diaginertia="0.004 0.004 0.0009"',
        'diaginertia="0.004 0.004 0.009"',
        "C-SOLID",
        'inertial of body "lower"',
        "diaginertia",
    ),
    "not definite": (
        'diaginertia="0.004 0.004 0.0009"',
        'fullinertia="0.004 0.004 0.0009 0.005 0 0"',
        "C-SOLID",
        'inertial of body "lower"',
        "fullinertia",
    ),
    "kg mm²": (
        'diaginertia="0.004 0.004 0.0009"',
        'diaginertia="4000 4000 900"',
        "C-INERTIAL",
        'inertial of body "lower"',
        "diaginertia",
    ),
    "grams": ('mass="1"', 'mass="1000"', "C-INERTIAL", 'inertial of body "lower"', "mass"),
    "center in mm": (
        'pos="0 0 0.1" mass',
        'pos="0 0 100" mass',
        "C-INERTIAL",
        'inertial of body "lower"',
        "pos",
    ),
    "mesh in mm": (
        'file="lower.stl"',
        'file="lower.stl" scale="1000 1000 1000"',
        "C-UNITS",
        'mesh "lower"',
        "scale",
    ),
    "collider moved": (
        '<geom name="upper" class="collision" pos="0 0 0.1"/>',
        '<geom name="upper" class="collision" pos="0 2 0.1"/>',
        "C-COLLIDER",
        'geom "upper"',
        "pos",
    ),
    "negative damping": (
        'joint damping="0.1"',
        'joint damping="-0.1"',
        "C-LIMIT",
        'joint "elbow"',
        "damping",
    ),
    "control swapped": (
        'ctrlrange="-1.5 1.5"',
        'ctrlrange="1.5 -1.5"',
        "C-LIMIT",
        'position "shoulder"',
        "ctrlrange",
    ),
    "control without range": ('ctrlrange="-1.5 1.5"', "", "C-PLAUSIBLE", 'position "shoulder"', "ctrlrange"),
    "no gain": ('kp="20"', 'kp="0"', "C-LIMIT", 'position "shoulder"', "kp"),
    "keyframe too short": ('qpos="0.1 0.1 0', 'qpos="0.1 0', "C-KEYS", 'key "home"', "qpos"),
    "control too long": ('ctrl="0.1"', 'ctrl="0.1 0"', "C-KEYS", 'key "home"', "ctrl"),
    "keyframe outside": ('qpos="0.1 0.1', 'qpos="2.1 2.1', "C-PLAUSIBLE", 'key "home"', "qpos"),
    "keyframe quaternion": ("0.3 1 0 0 0", "0.3 2 0 0 0", "C-PLAUSIBLE", 'key "home"', "qpos"),
    "keyframe no quaternion": ("0.3 1 0 0 0", "0.3 0 0 0 0", "C-KEYS", 'key "home"', "qpos"),
    "loop open": (
        'name="upper_end" pos="0 0 0.25"',
        'name="upper_end" pos="0 0 0.3"',
        "C-CLOSED",
        'connect "loop"',
        "site2",
    ),
    "relation open": ('qpos="0.1 0.1', 'qpos="0.1 0.4', "C-CLOSED", "joint of equality", "polycoef"),
    "inside at start": ("0 1 0.3 1 0 0 0", "0 0 0.3 1 0 0 0", "C-START", 'body "ball"', "pos"),
    "misspelled": ('armature="0.01"', 'armatur="0.01"', "C-XML-KNOWN", "joint of default", "armatur"),
}


@pytest.mark.parametrize("kind", OF_MJCF)
def test_a_fault_of_an_mjcf_is_found(folder, kind):
    old, new, *expected = OF_MJCF[kind]
    planted(folder / "arm.xml", old, new)
    assert tuple(expected) in found(check_bare(folder / "arm.xml"))


def test_at_least_eighteen_kinds_need_no_truth():
    assert len(OF_URDF) >= 18
    assert len(OF_MJCF) >= 18


def test_what_becomes_infinite_is_found(folder):
    """A servo whose gains the time step cannot follow."""
    planted(folder / "arm.xml", 'kp="20"', 'kp="1e7"')
    planted(folder / "arm.xml", "<asset>", '<option timestep="0.02"/><asset>')
    planted(folder / "arm.xml", 'qpos="0.1 0.1', 'qpos="0.4 0.4')
    assert "C-TRIAL" in {one.code for one in check_bare(folder / "arm.xml") if one.fails}


APART = {
    "mass": ('mass="1"', 'mass="1.1"', 'body "lower"', "mass"),
    "limit": (
        'name="elbow" axis="0 1 0" range="-1.5 1.5"',
        'name="elbow" axis="0 1 0" range="-1.5 1.2"',
        'joint "elbow"',
        "range",
    ),
    "place": (
        '<body name="lower" pos="0 0 0.25">',
        '<body name="lower" pos="0 0 0.26">',
        'body "lower"',
        "pos",
    ),
    "axis": ('name="elbow" axis="0 1 0"', 'name="elbow" axis="0 -1 0"', 'body "lower"', "pos"),
    "joint": ('<joint name="elbow" ', '<joint name="knee" ', 'joint "elbow"', "name"),
}


@pytest.mark.parametrize("kind", APART)
def test_what_the_two_files_of_a_robot_have_different_is_found(folder, kind):
    old, new, *expected = APART[kind]
    planted(folder / "arm.xml", old, new)
    if kind == "joint":
        planted(folder / "arm.xml", 'joint1="elbow"', 'joint1="knee"')
    together = next(one for one in check_bare(folder) if one.code == "C-TOGETHER")
    assert tuple(expected) in {(one.element, one.attribute) for one in together.findings}


def test_other_files_beside_models_are_left_alone(folder):
    (folder / "config.xml").write_text("<settings/>")
    (folder / "notes.txt").write_text("<")
    assert all(one.passed for one in check_bare(folder))


def test_frames_without_a_body_are_no_fault(folder):
    frame = (
        '<link name="tool"><inertial><mass value="1e-9"/>'
        '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>'
        '<joint name="tool" type="fixed"><parent link="lower"/><child link="tool"/></joint></robot>'
    )
    planted(folder / "arm.urdf", "</robot>", frame)
    assert all(one.passed for one in check_bare(folder / "arm.urdf"))


@pytest.mark.parametrize("name", FILES)
def test_the_files_of_others_have_no_error(name):
    """What they have that could be better is a warning."""
    if not is_here(name):
        pytest.skip("needs the robots of others")
    assert [one for one in check_bare(FILES[name][1]) if one.fails] == []


HARMLESS = {
    "a quaternion of another length": (
        "arm.xml",
        'pos="0 0 0.25" quat="1 0 0 0"',
        'pos="0 0 0.25" quat="2 0 0 0"',
    ),
    "a static base without mass": (
        "arm.xml",
        'mass="1" diaginertia="0.004 0.004 0.0009"/>\n      <geom class="visual" mesh="base"',
        'mass="0" diaginertia="0 0 0"/>\n      <geom class="visual" mesh="base"',
    ),
    "limits that stand for none": ("arm.urdf", 'lower="-1.5" upper="1.5"', 'lower="-10" upper="10"'),
    "huge limits": ("arm.urdf", 'lower="-1.5" upper="1.5"', 'lower="-1e16" upper="1e16"'),
}


@pytest.mark.parametrize("kind", HARMLESS)
def test_what_many_files_have_is_no_fault(folder, kind):
    file, old, new = HARMLESS[kind]
    planted(folder / file, old, new)
    assert [(one.code, one.detail) for one in check_bare(folder / file) if not one.passed] == []


MARKED = """<link name="imu"><inertial><mass value="{mass}"/>
<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><box size=".001 .001 .001"/></geometry></visual></link>
<joint name="imu" type="fixed"><parent link="lower"/><child link="imu"/></joint></robot>"""


@pytest.mark.parametrize("mass", ["0.001", "0.5", "0"])
def test_a_box_that_marks_a_sensor_is_not_its_form(folder, mass):
    planted(folder / "arm.urdf", "</robot>", MARKED.format(mass=mass))
    assert [(one.code, one.detail) for one in check_bare(folder / "arm.urdf") if not one.passed] == []


def test_a_fixed_link_may_be_a_point_and_may_not_have_a_negative_mass(folder):
    point = MARKED.replace("1e-4", "0")
    planted(folder / "arm.urdf", "</robot>", point.format(mass="0.5"))
    assert [one for one in check_bare(folder / "arm.urdf") if one.fails] == []
    planted(folder / "arm.urdf", 'value="0.5"', 'value="-0.5"')
    assert "C-SOLID" in {one.code for one in check_bare(folder / "arm.urdf") if one.fails}


def test_a_mesh_that_cannot_be_read_may_explain_what_is_odd(folder):
    text = (folder / "arm.urdf").read_text()
    wide = text.replace('ixx="0.004"', 'ixx="0.04"').replace('iyy="0.004"', 'iyy="0.04"')
    assert wide != text
    (folder / "arm.urdf").write_text(wide)
    assert "C-INERTIAL" in {one.code for one in check_bare(folder / "arm.urdf") if not one.passed}
    (folder / "other.dae").write_text("<COLLADA/>")
    seen = '<visual><geometry><mesh filename="other.dae"/></geometry></visual></link>'
    (folder / "arm.urdf").write_text(wide.replace("</link>", seen))
    assert "C-INERTIAL" not in {one.code for one in check_bare(folder / "arm.urdf") if not one.passed}
