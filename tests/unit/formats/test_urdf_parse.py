"""URDF text as values, with defaults for what it leaves out; its faults are named."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkwright.stages.formats.urdf.model import Transmission, UrdfMimic, mesh_key
from linkwright.stages.formats.urdf.parse import parse
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.model.dofs import Limits
from linkwright.stages.robot.model.poses import from_parts

BOX = '<box size="1 1 1"/>'


def read(body, name="r"):
    return parse(f'<?xml version="1.0"?>\n<robot name="{name}">{body}</robot>'.encode(), "r.urdf")


def sound(body):
    """A robot without diagnostics."""
    robot = read(body)
    assert robot.diagnostics == ()
    return robot


def joint(inner="", kind="revolute"):
    ends = '<parent link="a"/><child link="b"/>'
    return f'<link name="a"/><link name="b"/><joint name="j" type="{kind}">{ends}{inner}</joint>'


def of_joint(inner, kind="revolute"):
    """The joint of a sound robot."""
    (parsed,) = sound(joint(inner, kind)).joints
    return parsed


def inertial(inner):
    return sound(f'<link name="a"><inertial>{inner}</inertial></link>').links[0].inertial


def visual(geometry, more=""):
    return f'<link name="a"><visual>{more}<geometry>{geometry}</geometry></visual></link>'


def limits(effort, velocity, ends=None):
    return {"limits": ends and Limits(*ends), "effort": effort, "velocity": velocity}


JOINTS = {
    "the defaults of ROS": ("", {
        "name": "j", "type": "revolute", "parent": "a", "child": "b", "axis": [1, 0, 0], "mimic": None,
        "damping": None, "friction": None, **limits(None, None)}),
    "an axis of another length": ('<axis xyz="0 3 4"/>', {"axis": [0, 0.6, 0.8]}),
    "a range": ('<limit lower="-1" upper="2" effort="5" velocity="6"/>', limits(5, 6, (-1, 2))),
    "a limit without bounds": ('<limit effort="0" velocity="inf"/>', limits(0, None, (0, 0))),
    "infinite bounds": ('<limit lower="-inf" upper="inf"/>', limits(None, None, (None, None))),
    "dynamics": ('<dynamics damping="0.1" friction="0.2"/>', {"damping": 0.1, "friction": 0.2}),
    "a mimic": ('<mimic joint="k" multiplier="-2" offset="0.5"/>', {"mimic": UrdfMimic("k", -2, 0.5)}),
    "the defaults of a mimic": ('<mimic joint="k"/>', {"mimic": UrdfMimic("k", 1, 0)}),
    "a mimic of factor 0": ('<mimic joint="k" multiplier="0"/>', {"mimic": UrdfMimic("k", 0, 0)}),
}  # fmt: skip


@pytest.mark.parametrize(("inner", "expected"), JOINTS.values(), ids=JOINTS)
def test_fields_of_a_joint_are_read(inner, expected):
    parsed = of_joint(inner)
    for name, value in expected.items():
        field = getattr(parsed, name)
        assert field == (pytest.approx(value, abs=1e-15) if name == "axis" else value), name


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic", "fixed", "floating", "planar"])
def test_all_types_are_read_and_only_two_have_a_range(kind):
    parsed = of_joint('<limit lower="-1" upper="1" effort="1" velocity="2"/>', kind)
    assert (parsed.type, parsed.effort, parsed.velocity) == (kind, 1, 2)
    assert (parsed.limits is not None) == (kind in ("revolute", "prismatic"))


HALF = math.sqrt(0.5)


@pytest.mark.parametrize(("origin", "turned", "xyz"), [
    ("", np.eye(3), [0, 0, 0]),
    ('<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>', [[0, -1, 0], [1, 0, 0], [0, 0, 1]], [1, 2, 3]),
    (f'<origin quat_xyzw="0 0 {HALF} {HALF}"/>', [[0, -1, 0], [1, 0, 0], [0, 0, 1]], [0, 0, 0]),
    ('<origin xyz=" 1,\t2\n 3 "/>', np.eye(3), [1, 2, 3]),
], ids=["none", "angles", "a quaternion", "commas and whitespace"])  # fmt: skip
def test_origins_are_read(origin, turned, xyz):
    expected = from_parts(np.array(turned, float), np.array(xyz, float))
    np.testing.assert_allclose(of_joint(origin).parent_from_joint, expected, atol=1e-15)


def test_roll_pitch_and_yaw_turn_about_the_fixed_axes():
    parsed = of_joint('<origin rpy="0.3 -0.5 0.7"/>')
    expected = Rotation.from_euler("xyz", [0.3, -0.5, 0.7]).as_matrix()
    np.testing.assert_allclose(parsed.parent_from_joint[:3, :3], expected, atol=1e-15)


def test_inertial_is_in_the_links_frame_with_its_six_numbers():
    origin = '<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/><mass value="3"/>'
    turned = inertial(f'{origin}<inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="4"/>')
    assert (turned.mass, turned.com.tolist()) == (3, [1, 0, 0])
    np.testing.assert_allclose(turned.inertia, np.diag([2, 1, 4]), atol=1e-15)
    full = inertial('<mass value="1"/><inertia ixx="1" ixy="2" ixz="3" iyy="4" iyz="5" izz="6"/>')
    assert full.inertia.tolist() == [[1, 2, 3], [2, 4, 5], [3, 5, 6]]


def test_missing_parts_of_an_inertial_are_zero_and_reported():
    robot = read('<link name="a"><inertial/></link><link name="b"/>')
    assert robot.links[0].inertial.mass == 0
    assert robot.links[1].inertial is None
    assert [diagnostic.code for diagnostic in robot.diagnostics] == ["W-URDF-INERTIAL"]


@pytest.mark.parametrize(("geometry", "kind", "size"), [
    ('<box size="1 2 3"/>', "box", (1, 2, 3)),
    ('<sphere radius="0.5"/>', "sphere", (0.5,)),
    ('<cylinder radius="0.5" length="2"/>', "cylinder", (0.5, 2)),
    ('<capsule radius="0.5" length="2"/>', "capsule", (0.5, 2)),
    ('<mesh filename="a.stl" scale="1 -2 3"/>', "mesh", ()),
    ('<mesh filename="a.stl" scale="0.001"/>', "mesh", ()),
])  # fmt: skip
def test_every_shape_is_read(geometry, kind, size):
    (shape,) = sound(visual(geometry, '<origin xyz="0 0 1"/>')).links[0].visuals
    assert (shape.kind, shape.size) == (kind, size)
    assert shape.link_from_shape[2, 3] == 1
    if kind == "mesh":
        scale = (0.001, 0.001, 0.001) if "0.001" in geometry else (1, -2, 3)
        assert (shape.filename, shape.scale) == ("a.stl", scale)


def test_all_visuals_and_collisions_of_a_link_are_read_in_order():
    box, ball = '<geometry><box size="1 1 1"/></geometry>', '<geometry><sphere radius="1"/></geometry>'
    link = f"<visual>{box}</visual><collision>{ball}</collision><visual name='v'>{ball}</visual>"
    first = read(f'<link name="a">{link}<collision>{box}</collision></link>').links[0]
    assert [shape.kind for shape in first.visuals] == ["box", "sphere"]
    assert [shape.kind for shape in first.collisions] == ["sphere", "box"]
    assert first.visuals[1].name == "v"


def colours(body):
    return [shape.colour for link in read(body).links for shape in link.visuals]


RED = '<material name="red"><color rgba="1 0 0 1"/></material>'
USES_RED = visual(BOX, '<material name="red"/>')
OWN = '<material name="red"><color rgba="0 0 1 0.5"/></material>'
NAMELESS = '<material name=""><color rgba="0 1 0"/></material>'
TWICE = "".join(f'<material name="m"><color rgba="{c} 0 0 1"/></material>' for c in (0, 1))


def test_materials_are_a_visuals_own_or_named_in_the_file():
    for body, expected in (
        (USES_RED + RED, [(1, 0, 0, 1)]),
        (USES_RED.replace('"a"', '"b"') + visual(BOX, RED), [(1, 0, 0, 1)] * 2),
        (RED + visual(BOX, OWN), [(0, 0, 1, 0.5)]),
        (visual(BOX), [None]),
        (visual(BOX, NAMELESS), [(0, 1, 0, 1)]),
    ):
        assert colours(body) == expected, body
    assert sound(TWICE + visual(BOX)), "nobody uses the material that is there twice"


@pytest.mark.parametrize(("body", "code", "words"), [
    (joint('<origin xyz="1 2"/>'), "E-URDF-NUMBER", '<origin xyz="1 2">: expected 3 finite numbers'),
    (joint('<origin xyz="0,5 0 0"/>'), "E-URDF-NUMBER", "3 finite numbers"),
    (joint('<origin rpy="nan 0 0"/>'), "E-URDF-NUMBER", "finite"),
    (joint('<axis xyz="1e999 0 0"/>'), "E-URDF-NUMBER", "finite"),
    (joint('<axis xyz="0 0 0"/>'), "E-URDF-AXIS", "no direction"),
    (joint('<limit lower="nan" upper="1"/>'), "E-URDF-NUMBER", "expected a number"),
    (joint('<limit lower="1" upper="-1"/>'), "E-URDF-LIMIT", "above"),
    (joint('<limit lower="1_0" upper="20"/>'), "E-URDF-NUMBER", "1_0"),
    (joint('<dynamics damping="-1"/>'), "E-URDF-NUMBER", "negative"),
    (joint("<mimic/>"), "E-URDF-MIMIC", 'joint="…"'),
    (joint(kind="hinge"), "E-URDF-TYPE", '"hinge"'),
    ('<link name="a"/><joint name="j" type="fixed"><child link="a"/></joint>', "E-URDF-JOINT", "<parent"),
    ('<link name="a"/>\n<link name="a"/>', "E-URDF-NAME", "line 2"),
    ('<link name="a"/><link name="a"/>', "E-URDF-NAME", "line 2"),
    (joint() + '<transmission name="t"><joint name="j"/><actuator name="m">'
     '<rotor_inertia value="-1"/></actuator></transmission>', "E-URDF-NUMBER", "must not be negative"),
    ('<link name=" "/>', "E-URDF-NAME", "no name"),
    ("", "E-URDF-EMPTY", "no link"),
    (visual('<box size="1 -1 1"/>'), "E-URDF-SHAPE", "size"),
    (USES_RED, "W-URDF-MATERIAL", 'there is no material "red"'),
    (TWICE + visual(BOX, '<material name="m"/>'), "W-URDF-MATERIAL", ""),
    (visual(BOX, '<material><color rgba="255 0 -1 1"/></material>'), "W-URDF-COLOUR", "(1, 0, 0, 1)"),
    (visual(BOX, '<material><texture filename="a.png"/></material>'), "I-URDF-TEXTURE", "a.png"),
    (visual("<sphere/>"), "E-URDF-SHAPE", "radius"),
    (visual("<mesh/>"), "E-URDF-MESH", "filename"),
    (visual('<mesh filename="a.stl" scale="1 0 1"/>'), "E-URDF-NUMBER", "no scale may be 0"),
    (visual('<sphere radius="0"/>'), "W-URDF-SHAPE", "no extent"),
    ('<link name="a"><visual/></link>', "W-URDF-SHAPE", "no known shape"),
    (visual('<box size="1 1 1"/><sphere radius="1"/>'), "W-URDF-TWICE", "first counts"),
    ('<link name="a" colour="red"/>', "W-URDF-UNKNOWN", 'colour="" of <link>'),
    ('<link name="a"><vizual/></link>', "W-URDF-UNKNOWN", "<vizual> in <link>"),
    ('<link name="a"><contact/></link><gazebo/><gazebo/>', "I-URDF-LEFT", "<contact> (1), <gazebo> (2)"),
])  # fmt: skip
def test_faults_and_ignored_elements_are_reported_with_lines(body, code, words):
    (diagnostic,) = [diagnostic for diagnostic in read(body).diagnostics if diagnostic.code == code]
    assert words in diagnostic.message
    assert diagnostic.where.startswith("r.urdf")


def test_all_faults_are_reported_at_once_in_order_of_lines():
    body = f"""
        {joint('<origin xyz="x"/>', "hinge")}
        <link name="a"><inertial><mass value="nan"/></inertial></link>"""
    diagnostics = read(body).diagnostics
    errors = [problem.code for problem in diagnostics if problem.level == "error"]
    assert errors == ["E-URDF-TYPE", "E-URDF-NUMBER", "E-URDF-NAME"]


def test_errors_and_warnings_beyond_fifty_are_counted():
    errors = [problem for problem in read("<link/>" * 1000).diagnostics if problem.level == "error"]
    assert len(errors) == 51
    assert errors[-1].message == "and 950 more errors"
    links = "".join(f'<link name="{n}"><inertial/></link>' for n in range(60))
    unknown = "".join(f"<thing_{n}/>" for n in range(53))
    warnings = read(links + unknown).diagnostics
    assert len(warnings) == 50 + 1 + 50
    (more,) = (problem.message for problem in warnings if problem.code == "W-URDF-MORE")
    assert more == "and 13 more warnings"


def test_transmissions_of_all_styles_are_read():
    older = """<transmission name="t" type="pr2/Simple"><actuator name="m"/><joint name="j"/>
        <mechanicalReduction>50</mechanicalReduction></transmission>"""
    newer = """<transmission name="t"><type>ti/Simple</type>
        <joint name="j"><hardwareInterface>Effort</hardwareInterface></joint>
        <actuator name="m"><mechanicalReduction>50</mechanicalReduction></actuator></transmission>"""
    control = """<ros2_control name="c" type="system"><hardware><plugin>p/P</plugin></hardware>
        <joint name="j"><command_interface name="position"/><state_interface name="velocity"/></joint>
        <joint name="passive"><state_interface name="position"/></joint>
        <transmission name="t"><plugin>ti/Simple</plugin>
        <joint name="j"><mechanical_reduction>50</mechanical_reduction></joint></transmission>
        </ros2_control>"""
    link = '<link name="a"/>'
    assert sound(link + older).transmissions == (Transmission("t", "j", "pr2/Simple", 50, ()),)
    assert sound(link + newer).transmissions == (Transmission("t", "j", "ti/Simple", 50, ("Effort",)),)
    assert sound(link + control).transmissions == (
        Transmission("c", "j", "p/P", 1, ("position",)),
        Transmission("t", "j", "ti/Simple", 50, ()),
    )


def test_prefix_without_a_namespace_and_a_comment_do_not_matter():
    robot = read('<!-- <link name="x"/> --><link name="a"/><controller:plugin/>')
    assert [link.name for link in robot.links] == ["a"]
    assert [diagnostic.code for diagnostic in robot.diagnostics] == ["W-URDF-UNKNOWN"]


@pytest.mark.parametrize(("text", "words"), [
    (b"", "empty"),
    (b"no xml", "line 1"),
    (b"<robot><link></robot>", "line 1"),
    (b'<mujoco model="a"/>', "source=mjcf"),
    (b"<sdf/>", "SDF"),
    (b'<!DOCTYPE r [<!ENTITY x "y">]><robot name="a"><link name="b"/></robot>', "entities"),
])  # fmt: skip
def test_other_files_are_refused(text, words):
    with pytest.raises(SourceError) as caught:
        parse(text, "r.urdf")
    assert words in str(caught.value)
    assert caught.value.where == "r.urdf"


def test_key_of_a_mesh_depends_on_file_scale_and_colour_only():
    def key(filename="a/Mesh 1.stl", scale="1 1 1", more=""):
        (shape,) = read(visual(f'<mesh filename="{filename}" scale="{scale}"/>', more)).links[0].visuals
        return mesh_key(shape)

    red = '<material><color rgba="1 0 0 1"/></material>'
    assert key().startswith("Mesh_1-")
    assert key() == key(more='<origin xyz="1 2 3"/>')
    assert len({key(), key("b/Mesh 1.stl"), key(scale="1 1 -1"), key(more=red)}) == 4
