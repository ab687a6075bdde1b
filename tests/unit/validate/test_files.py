"""Checks of files: each fault of the text is found with its element and attribute, and nothing else is."""

import os
import struct
import subprocess
import sys
from pathlib import Path

import mujoco
import pytest

from linkwright.stages.robot.check import Check
from linkwright.stages.validate.files.run import check_document, check_folder, opened
from linkwright.stages.validate.reading.documents import read
from tests.support.mujoco_schema import schema
from tests.support.other_robots import FILES
from tests.support.places import PROJECT

URDF = """<?xml version='1.0'?>
<robot name="arm">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="base">
    <visual><geometry><mesh filename="assets/base.stl"/></geometry><material name="grey"/></visual>
  </link>
  <link name="elbow">
    <inertial><origin xyz="0 0 0.1"/><mass value="1"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <collision><geometry><box size="0.1 0.1 0.2"/></geometry></collision>
  </link>
  <link name="hand"/>
  <joint name="elbow" type="revolute">
    <parent link="base"/><child link="elbow"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="inf"/>
  </joint>
  <joint name="wrist" type="revolute">
    <parent link="elbow"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/><mimic joint="elbow" multiplier="2"/>
  </joint>
  <gazebo reference="base"><mu1>0.9</mu1></gazebo>
</robot>
"""

MJCF = """<mujoco model="arm">
  <compiler angle="radian" meshdir="assets"/>
  <default>
    <default class="visual"><geom group="2" contype="0" conaffinity="0" density="0"/></default>
  </default>
  <asset>
    <material name="grey" rgba="0.5 0.5 0.5 1"/>
    <mesh file="base.stl" inertia="shell"/>
  </asset>
  <worldbody>
    <body name="base">
      <geom class="visual" type="mesh" mesh="base" material="grey"/>
      <site name="mount" pos="0 0 0.1"/>
      <body name="elbow" pos="0 0 0.1" quat="1 0 0 0">
        <joint name="elbow" axis="0 0 1" range="-1 1"/>
        <inertial pos="0 0 0.1" mass="1" diaginertia="0.01 0.01 0.01"/>
        <geom name="elbow" type="box" size="0.1 0.1 0.2"/>
        <site name="tip" pos="0 0 0.2"/>
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="base" body2="elbow"/></contact>
  <equality><connect name="loop" site1="mount" site2="tip" active="false"/></equality>
  <actuator><position name="elbow" joint="elbow" kp="10" ctrlrange="-1 1"/></actuator>
  <sensor><framepos name="where" objtype="site" objname="tip"/><jointpos name="angle" joint="elbow"/></sensor>
</mujoco>
"""

SCENE = """<mujoco model="scene"><include file="arm.xml"/>
<asset><texture name="checker" type="2d" builtin="checker" width="9" height="9"/>
<material name="floor" texture="checker"/></asset>
<worldbody><geom name="floor" type="plane" size="1 1 1" material="floor"/></worldbody></mujoco>
"""

STL = (
    b"\0" * 80
    + struct.pack("<I", 4)
    + b"".join(
        struct.pack("<12fH", 0, 0, 1, *corners, 0)
        for corners in (
            (0, 0, 0, 0, 1, 0, 1, 0, 0),
            (0, 0, 0, 1, 0, 0, 0, 0, 1),
            (0, 0, 0, 0, 0, 1, 0, 1, 0),
            (1, 0, 0, 0, 1, 0, 0, 0, 1),
        )
    )
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / "base.stl").write_bytes(STL)
    for name, text in (("arm.urdf", URDF), ("arm.xml", MJCF), ("scene.xml", SCENE)):
        (tmp_path / name).write_text(text)
    return tmp_path


def checked(folder: Path) -> list[Check]:
    return list(check_folder(folder, ("arm.xml", "scene.xml", "arm.urdf")))


def wrong(folder: Path) -> set[tuple[str, str, str, str]]:
    """File, code, element and attribute of each finding."""
    return {
        (check.name.partition(":")[0], check.code, one.element, one.attribute)
        for check in checked(folder)
        if not check.passed
        for one in check.findings
    }


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_good_files_pass_every_check(folder):
    assert wrong(folder) == set()
    assert {one.code for one in checked(folder)} >= {
        *("C-XML", "C-XML-KNOWN", "C-NAME", "C-NUMBER", "C-REFERENCE", "C-ASSET", "C-PATH", "C-ASSET-UNUSED")
    }
    mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))  # what is called good is


OF_URDF = [
    ("<robot", "<robots", "C-XML", "XML", ""),
    ('<limit lower="-1"', '<limits lower="-1"', "C-XML", "XML", ""),
    ('velocity="2"', 'velocty="2"', "C-XML-KNOWN", 'limit of joint "wrist"', "velocty"),
    ("<collision>", "<colision/><collision>", "C-XML-KNOWN", 'colision of link "elbow"', ""),
    ('<link name="hand"', '<link name="elbow"', "C-NAME", 'link "elbow"', "name"),
    ('<joint name="wrist"', '<joint name="elbow"', "C-NAME", 'joint "elbow"', "name"),
    ('<link name="hand"', '<link name=""', "C-NAME", "link", "name"),
    ('<link name="hand"', '<link name=" hand"', "C-NAME", 'link " hand"', "name"),
    ('<mass value="1"', '<mass value="nan"', "C-NUMBER", 'mass of link "elbow"', "value"),
    ('<mass value="1"', '<mass value="1e999"', "C-NUMBER", 'mass of link "elbow"', "value"),
    ('<mass value="1"', '<mass value="1,5"', "C-NUMBER", 'mass of link "elbow"', "value"),
    ('<mass value="1"', "<mass", "C-NUMBER", 'mass of link "elbow"', "value"),
    ('xyz="0 0 0.1"', 'xyz="0 0"', "C-NUMBER", 'origin of link "elbow"', "xyz"),
    ('upper="1"', 'upper="one"', "C-NUMBER", 'limit of joint "elbow"', "upper"),
    ('<parent link="elbow"', '<parent link="elbov"', "C-REFERENCE", 'parent of joint "wrist"', "link"),
    ('<child link="hand"', '<child link="hands"', "C-REFERENCE", 'child of joint "wrist"', "link"),
    ('<child link="hand"/>', "", "C-REFERENCE", 'joint "wrist"', "child"),
    ('<mimic joint="elbow"', '<mimic joint="knee"', "C-REFERENCE", 'mimic of joint "wrist"', "joint"),
    ('<material name="grey"/>', '<material name="red"/>', "C-REFERENCE", 'material "red"', "name"),
    ("assets/base", "assets/bose", "C-ASSET", 'mesh of visual of link "base"', "filename"),
    ("assets/base", "/tmp/assets/base", "C-PATH", 'mesh of visual of link "base"', "filename"),
    ("assets/base", "../x/assets/base", "C-PATH", 'mesh of visual of link "base"', "filename"),
    ("assets/base", "package://other/base", "C-PATH", 'mesh of visual of link "base"', "filename"),
    (
        '<joint name="elbow"',
        '<transmission name="t"><joint name="knee"/></transmission><joint name="elbow"',
        *("C-REFERENCE", 'joint "knee"', "name"),
    ),
]


@pytest.mark.parametrize(("old", "new", "code", "element", "attribute"), OF_URDF)
def test_a_fault_of_a_urdf_is_found_where_it_is(folder, old, new, code, element, attribute):
    edit(folder / "arm.urdf", old, new)
    text = folder / "arm.urdf"
    if old == "<robot":
        text.write_text(text.read_text().replace("</robot>", "</robots>"))
        code, element = "C-XML", "<robots>"
    elif code == "C-XML":
        edit(folder / "arm.urdf", "</joint>", "</joints>")
    assert ("arm.urdf", code, element, attribute) in wrong(folder)
    assert {file for file, *_ in wrong(folder)} == {"arm.urdf"}


OF_MJCF = [
    ('range="-1 1"/>', 'rnage="-1 1"/>', "C-XML-KNOWN", 'joint "elbow"', "rnage"),
    ("<contact>", "<contacts/><contact>", "C-XML-KNOWN", "contacts", ""),
    ("<sensor>", '<sensor><gyroo name="g" site="tip"/>', "C-XML-KNOWN", 'gyroo "g"', ""),
    ('<body name="elbow"', '<body name="base"', "C-NAME", 'body "base"', "name"),
    ('<site name="tip"', '<site name="mount"', "C-NAME", 'site "mount"', "name"),
    ('<jointpos name="angle"', '<jointpos name="where"', "C-NAME", 'jointpos "where"', "name"),
    ("<mesh file", '<mesh file="base.stl"/><mesh file', "C-NAME", 'mesh "base"', "file"),
    ('diaginertia="0.01 ', 'diaginertia="nan ', "C-NUMBER", 'inertial of body "elbow"', "diaginertia"),
    ('pos="0 0 0.2"', 'pos="0 0 x"', "C-NUMBER", 'site "tip"', "pos"),
    ('quat="1 0 0 0"', 'quat="1 0 0"', "C-NUMBER", 'body "elbow"', "quat"),
    ('kp="10"', 'kp="ten"', "C-NUMBER", 'position "elbow"', "kp"),
    ('<geom class="visual"', '<geom class="visuel"', "C-REFERENCE", 'geom of body "base"', "class"),
    ('mesh="base"', 'mesh="bose"', "C-REFERENCE", 'geom of body "base"', "mesh"),
    ('material="grey"', 'material="gray"', "C-REFERENCE", 'geom of body "base"', "material"),
    ('body2="elbow"', 'body2="knee"', "C-REFERENCE", "exclude of contact", "body2"),
    ('site2="tip"', 'site2="top"', "C-REFERENCE", 'connect "loop"', "site2"),
    ('joint="elbow" kp', 'joint="knee" kp', "C-REFERENCE", 'position "elbow"', "joint"),
    ('objname="tip"', 'objname="top"', "C-REFERENCE", 'framepos "where"', "objname"),
    (
        '<jointpos name="angle" joint="elbow"',
        '<jointpos name="angle" joint="x"',
        "C-REFERENCE",
        'jointpos "angle"',
        "joint",
    ),
    ('file="base.stl"', 'file="bose.stl" name="base"', "C-ASSET", 'mesh "base"', "file"),
    ('file="base.stl"', 'file="/a/base.stl" name="base"', "C-ASSET", 'mesh "base"', "file"),
    ('meshdir="assets"', 'meshdir="../x/assets"', "C-PATH", "compiler", "meshdir"),
]


@pytest.mark.parametrize(("old", "new", "code", "element", "attribute"), OF_MJCF)
def test_a_fault_of_an_mjcf_is_found_where_it_is(folder, old, new, code, element, attribute):
    edit(folder / "arm.xml", old, new)
    assert ("arm.xml", code, element, attribute) in wrong(folder)
    assert {file for file, *_ in wrong(folder)} == {"arm.xml"}
    with pytest.raises(ValueError, match="Error"):
        mujoco.MjModel.from_xml_path(str(folder / "arm.xml"))


def test_faults_of_a_scene_are_its_own(folder):
    edit(folder / "scene.xml", 'material="floor"', 'material="flour"')
    assert wrong(folder) == {("scene.xml", "C-REFERENCE", 'geom "floor"', "material")}


def test_a_name_that_the_model_has_already_is_found_in_the_scene(folder):
    edit(folder / "scene.xml", '<geom name="floor"', '<geom name="elbow"')
    assert wrong(folder) == {("scene.xml", "C-NAME", 'geom "elbow"', "name")}
    (finding,) = (one for check in checked(folder) for one in check.findings)
    assert "arm.xml, line" in finding.message


def test_an_include_that_is_missing_is_found(folder):
    edit(folder / "scene.xml", '"arm.xml"', '"leg.xml"')
    assert wrong(folder) == {("scene.xml", "C-XML", "include", "file")}


def test_a_file_that_includes_itself_is_found(folder):
    edit(folder / "scene.xml", '"arm.xml"', '"scene.xml"')
    assert ("scene.xml", "C-XML", "include", "file") in wrong(folder)


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("base.stl", b""),
        ("base.stl", STL[:-7]),
        ("base.stl", STL[:60]),
        ("base.stl", b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"),
        ("base.stl", STL[:100] + struct.pack("<f", float("nan")) + STL[104:]),
        ("base.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
        ("base.obj", b"v 0 0 0\n"),
        ("base.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("base.dae", b"<COLLADA><asset>"),
        ("base.glb", b"glTF" + struct.pack("<II", 2, 100) + b"\0" * 40),
    ],
)
def test_a_mesh_that_is_not_whole_is_found(folder, name, data):
    (folder / "assets" / name).write_bytes(data)
    edit(folder / "arm.urdf", "base.stl", name)
    assert ("arm.urdf", "C-ASSET", 'mesh of visual of link "base"', "filename") in wrong(folder)


def test_a_file_that_no_model_names_is_a_warning(folder):
    (folder / "assets" / "old.stl").write_bytes(STL)
    (check,) = (one for one in checked(folder) if not one.passed)
    assert (check.code, check.level) == ("C-ASSET-UNUSED", "warning")
    assert check.findings[0].element == "assets/old.stl"
    (folder / "arm.sdf").write_text("<sdf><uri>model://arm/assets/old.stl</uri></sdf>")
    assert all(one.passed for one in check_folder(folder, ("arm.xml", "arm.urdf"), ("arm.sdf",)))


def test_an_unknown_element_is_an_error_where_the_engine_refuses_it(folder):
    edit(folder / "arm.urdf", 'velocity="2"', 'velocty="2"')
    edit(folder / "arm.xml", 'range="-1 1"/>', 'rnage="-1 1"/>')
    levels = {one.name: one.level for one in checked(folder) if not one.passed}
    assert levels == {"arm.urdf: elements": "warning", "arm.xml: elements": "error"}


def test_a_finding_names_its_line(folder):
    edit(folder / "arm.xml", 'kp="10"', 'kp="ten"')
    (finding,) = (one for check in checked(folder) for one in check.findings)
    line = next(number for number, text in enumerate(MJCF.splitlines(), 1) if 'kp="10"' in text)
    assert f"(line {line})" in finding.message


def test_entities_are_no_xml_that_is_read(folder):
    (folder / "arm.urdf").write_text('<!DOCTYPE r [<!ENTITY a "b">]><robot name="&a;"/>')
    document, check = opened(folder / "arm.urdf")
    assert document is None
    assert not check.passed


@pytest.mark.parametrize(("way", "attributes"), [one for one in schema() if one[0]])
def test_every_element_that_mujoco_lists_is_known(way, attributes, tmp_path):
    tags = ["worldbody" if index == 0 and tag == "body" else tag for index, tag in enumerate(way)]
    text = "".join(f"<{tag}>" for tag in tags[:-1]) + f"<{tags[-1]}"
    if tags[-1] != "worldbody":
        text += "".join(f' {name}=""' for name in attributes)
    text += "/>" + "".join(f"</{tag}>" for tag in reversed(tags[:-1]))
    (tmp_path / "one.xml").write_text(f"<mujoco>{text}</mujoco>")
    document = read(tmp_path / "one.xml")
    found = {one.code: one for one in check_document(document)}
    assert found["C-XML-KNOWN"].passed, found["C-XML-KNOWN"].detail


@pytest.mark.parametrize("name", FILES)
def test_the_files_of_others_have_no_error(name):
    path = FILES[name][1]
    if not path.exists():
        pytest.skip("needs the robots of others")
    assert [one for one in check_folder(path.parent, [path.name]) if one.fails] == []


def test_models_compile_from_another_folder(folder):
    """The checks find files from where the model lies, not from where the program runs."""
    code = (
        "from pathlib import Path; from linkwright.stages.validate.files.run import check_folder;"
        f"print(all(one.passed for one in check_folder(Path({str(folder)!r}), ['arm.xml', 'arm.urdf'])))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd="/",
        env={**os.environ, "PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "True"
