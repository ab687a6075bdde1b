"""URDF text as values: what it says, what it leaves out, and what is wrong with it."""

import math

import numpy as np
import pytest

from linkwright.stages.formats.urdf.model import Transmission, Urdf, mesh_key
from linkwright.stages.formats.urdf.parse import parse
from linkwright.stages.robot.errors import SourceError


def read(body: str, name: str = "r") -> Urdf:
    return parse(f'<?xml version="1.0"?>\n<robot name="{name}">{body}</robot>'.encode(), "r.urdf")


def sound(body: str) -> Urdf:
    """A robot about which there is nothing to tell."""
    robot = read(body)
    assert robot.diagnostics == ()
    return robot


def told(body: str) -> list[tuple[str, str]]:
    return [(one.code, one.message) for one in read(body).diagnostics]


def joint(inner: str = "", kind: str = "revolute") -> str:
    ends = '<parent link="a"/><child link="b"/>'
    return f'<link name="a"/><link name="b"/><joint name="j" type="{kind}">{ends}{inner}</joint>'


def visual(geometry: str, more: str = "") -> str:
    return f'<link name="a"><visual>{more}<geometry>{geometry}</geometry></visual></link>'


def test_what_a_joint_leaves_out_is_as_in_ros():
    (one,) = sound(joint()).joints
    assert (one.name, one.type, one.parent, one.child) == ("j", "revolute", "a", "b")
    assert np.array_equal(one.parent_from_joint, np.eye(4))
    assert one.axis.tolist() == [1, 0, 0]
    assert (one.limits, one.effort, one.velocity, one.damping, one.friction, one.mimic) == (None,) * 6


def test_everything_that_a_joint_may_say():
    inner = """
        <origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>
        <axis xyz="0 3 4"/>
        <limit lower="-1" upper="2" effort="5" velocity="6"/>
        <dynamics damping="0.1" friction="0.2"/>
        <mimic joint="k" multiplier="-2" offset="0.5"/>"""
    (one,) = sound(joint(inner)).joints
    expected = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    np.testing.assert_allclose(one.parent_from_joint, expected, atol=1e-15)
    np.testing.assert_allclose(one.axis, [0, 0.6, 0.8], atol=1e-15)
    assert (one.limits.lower, one.limits.upper, one.effort, one.velocity) == (-1, 2, 5, 6)
    assert (one.damping, one.friction) == (0.1, 0.2)
    assert (one.mimic.joint, one.mimic.multiplier, one.mimic.offset) == ("k", -2, 0.5)


def test_roll_pitch_and_yaw_turn_about_the_fixed_axes():
    (one,) = sound(joint('<origin rpy="0.3 -0.5 0.7"/>')).joints
    r, p, y = 0.3, -0.5, 0.7
    about_x = [[1, 0, 0], [0, math.cos(r), -math.sin(r)], [0, math.sin(r), math.cos(r)]]
    about_y = [[math.cos(p), 0, math.sin(p)], [0, 1, 0], [-math.sin(p), 0, math.cos(p)]]
    about_z = [[math.cos(y), -math.sin(y), 0], [math.sin(y), math.cos(y), 0], [0, 0, 1]]
    expected = np.array(about_z) @ np.array(about_y) @ np.array(about_x)
    np.testing.assert_allclose(one.parent_from_joint[:3, :3], expected, atol=1e-15)


def test_a_quaternion_may_stand_for_the_angles():
    half = math.sqrt(0.5)
    (one,) = sound(joint(f'<origin quat_xyzw="0 0 {half} {half}"/>')).joints
    np.testing.assert_allclose(one.parent_from_joint[:2, :2], [[0, -1], [1, 0]], atol=1e-15)


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic", "fixed", "floating", "planar"])
def test_all_types_are_read_and_only_two_have_a_range(kind):
    (one,) = sound(joint('<limit lower="-1" upper="1" effort="1" velocity="2"/>', kind)).joints
    assert one.type == kind
    assert (one.limits is not None) == (kind in ("revolute", "prismatic"))
    assert (one.effort, one.velocity) == (1, 2)


def test_a_limit_without_bounds_is_closed_at_zero_and_an_infinite_one_is_open():
    (one,) = sound(joint('<limit effort="0" velocity="inf"/>')).joints
    assert (one.limits.lower, one.limits.upper, one.effort, one.velocity) == (0, 0, 0, None)
    (one,) = sound(joint('<limit lower="-inf" upper="inf"/>')).joints
    assert (one.limits.lower, one.limits.upper, one.effort) == (None, None, None)


def test_a_mimic_has_multiplier_1_and_offset_0_unless_it_says_otherwise():
    (one,) = sound(joint('<mimic joint="k"/>')).joints
    assert (one.mimic.multiplier, one.mimic.offset) == (1, 0)
    (one,) = sound(joint('<mimic joint="k" multiplier="0"/>')).joints
    assert one.mimic.multiplier == 0


def test_an_inertial_is_reported_in_the_links_frame():
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="4"/>'
    origin = '<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>'
    robot = sound(f'<link name="a"><inertial>{origin}<mass value="3"/>{inertia}</inertial></link>')
    inertial = robot.links[0].inertial
    assert inertial.mass == 3
    assert inertial.com.tolist() == [1, 0, 0]
    np.testing.assert_allclose(inertial.inertia, np.diag([2, 1, 4]), atol=1e-15)


def test_the_tensor_has_its_six_numbers_where_they_belong():
    inertia = '<inertia ixx="1" ixy="2" ixz="3" iyy="4" iyz="5" izz="6"/>'
    robot = sound(f'<link name="a"><inertial><mass value="1"/>{inertia}</inertial></link>')
    assert robot.links[0].inertial.inertia.tolist() == [[1, 2, 3], [2, 4, 5], [3, 5, 6]]


def test_what_an_inertial_lacks_is_zero_and_reported():
    robot = read('<link name="a"><inertial/></link><link name="b"/>')
    assert robot.links[0].inertial.mass == 0
    assert robot.links[1].inertial is None
    assert [one.code for one in robot.diagnostics] == ["W-URDF-INERTIAL"]


@pytest.mark.parametrize(
    ("geometry", "kind", "size"),
    [
        ('<box size="1 2 3"/>', "box", (1, 2, 3)),
        ('<sphere radius="0.5"/>', "sphere", (0.5,)),
        ('<cylinder radius="0.5" length="2"/>', "cylinder", (0.5, 2)),
        ('<capsule radius="0.5" length="2"/>', "capsule", (0.5, 2)),
        ('<mesh filename="a.stl" scale="1 -2 3"/>', "mesh", ()),
    ],
)
def test_every_shape_is_read(geometry, kind, size):
    (shape,) = sound(visual(geometry, '<origin xyz="0 0 1"/>')).links[0].visuals
    assert (shape.kind, shape.size) == (kind, size)
    assert shape.link_from_shape[2, 3] == 1
    if kind == "mesh":
        assert (shape.filename, shape.scale) == ("a.stl", (1, -2, 3))


def test_all_visuals_and_collisions_of_a_link_are_read_in_order():
    box, ball = '<geometry><box size="1 1 1"/></geometry>', '<geometry><sphere radius="1"/></geometry>'
    link = f"<visual>{box}</visual><collision>{ball}</collision><visual name='v'>{ball}</visual>"
    one = read(f'<link name="a">{link}<collision>{box}</collision></link>').links[0]
    assert [shape.kind for shape in one.visuals] == ["box", "sphere"]
    assert [shape.kind for shape in one.collisions] == ["sphere", "box"]
    assert one.visuals[1].name == "v"


def test_one_number_scales_a_mesh_evenly():
    (shape,) = sound(visual('<mesh filename="a.stl" scale="0.001"/>')).links[0].visuals
    assert shape.scale == (0.001, 0.001, 0.001)


def colours(body: str) -> list[tuple[float, ...] | None]:
    return [shape.colour for link in read(body).links for shape in link.visuals]


def test_materials_are_the_visuals_own_or_named_from_anywhere_in_the_file():
    box = '<box size="1 1 1"/>'
    red = '<material name="red"><color rgba="1 0 0 1"/></material>'
    assert colours(visual(box, '<material name="red"/>') + red) == [(1, 0, 0, 1)]
    other = visual(box, '<material name="red"/>').replace('"a"', '"b"')
    assert colours(other + visual(box, red)) == [(1, 0, 0, 1)] * 2
    own = '<material name="red"><color rgba="0 0 1 0.5"/></material>'
    assert colours(red + visual(box, own)) == [(0, 0, 1, 0.5)]
    assert colours(visual(box)) == [None]
    assert colours(visual(box, '<material name=""><color rgba="0 1 0"/></material>')) == [(0, 1, 0, 1)]


def test_what_is_doubtful_about_a_material_is_reported():
    box = '<box size="1 1 1"/>'
    assert told(visual(box, '<material name="red"/>')) == [("W-URDF-MATERIAL", 'there is no material "red"')]
    ((code, message),) = told(visual(box, '<material><color rgba="255 0 -1 1"/></material>'))
    assert code == "W-URDF-COLOUR"
    assert "(1, 0, 0, 1)" in message
    textured = '<material><texture filename="a.png"/></material>'
    ((code, message),) = told(visual(box, textured))
    assert (code, "a.png" in message) == ("I-URDF-TEXTURE", True)
    twice = "".join(f'<material name="m"><color rgba="{c} 0 0 1"/></material>' for c in (0, 1))
    ((code, _),) = told(twice + visual(box, '<material name="m"/>'))
    assert code == "W-URDF-MATERIAL"
    assert told(twice + visual(box)) == []


@pytest.mark.parametrize(
    ("body", "code", "words"),
    [
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
        ('<link name=" "/>', "E-URDF-NAME", "no name"),
        ("", "E-URDF-EMPTY", "no link"),
        (visual('<box size="1 -1 1"/>'), "E-URDF-SHAPE", "size"),
        (visual("<sphere/>"), "E-URDF-SHAPE", "radius"),
        (visual("<mesh/>"), "E-URDF-MESH", "filename"),
        (visual('<mesh filename="a.stl" scale="1 0 1"/>'), "E-URDF-NUMBER", "no scale may be 0"),
        (visual('<sphere radius="0"/>'), "W-URDF-SHAPE", "no extent"),
        ('<link name="a"><visual/></link>', "W-URDF-SHAPE", "no known shape"),
        (visual('<box size="1 1 1"/><sphere radius="1"/>'), "W-URDF-TWICE", "first counts"),
        ('<link name="a" colour="red"/>', "W-URDF-UNKNOWN", 'colour="" of <link>'),
        ('<link name="a"><vizual/></link>', "W-URDF-UNKNOWN", "<vizual> in <link>"),
        ('<link name="a"><contact/></link><gazebo/><gazebo/>', "I-URDF-LEFT", "<contact> (1), <gazebo> (2)"),
    ],
)
def test_what_is_wrong_or_left_out_is_reported_with_its_line(body, code, words):
    found = [one for one in read(body).diagnostics if one.code == code]
    assert len(found) == 1
    assert words in found[0].message
    assert found[0].where.startswith("r.urdf")


def test_commas_and_any_whitespace_part_numbers():
    (one,) = sound(joint('<origin xyz=" 1,\t2\n 3 "/>')).joints
    assert one.parent_from_joint[:3, 3].tolist() == [1, 2, 3]


def test_everything_wrong_is_reported_at_once_in_the_order_of_lines():
    body = f"""
        {joint('<origin xyz="x"/>', "hinge")}
        <link name="a"><inertial><mass value="nan"/></inertial></link>"""
    found = read(body).diagnostics
    assert [one.code for one in found if one.level == "error"] == [
        "E-URDF-TYPE", "E-URDF-NUMBER", "E-URDF-NAME",
    ]  # fmt: skip


def test_errors_without_end_are_counted():
    found = [one for one in read("<link/>" * 1000).diagnostics if one.level == "error"]
    assert len(found) == 51
    assert found[-1].message == "and 950 more errors"


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


def test_a_prefix_without_a_namespace_and_a_comment_are_no_matter():
    robot = read('<!-- <link name="x"/> --><link name="a"/><controller:plugin/>')
    assert [link.name for link in robot.links] == ["a"]
    assert [one.code for one in robot.diagnostics] == ["W-URDF-UNKNOWN"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"", "empty"),
        (b"no xml", "line 1"),
        (b"<robot><link></robot>", "line 1"),
        (b'<mujoco model="a"/>', "source=mjcf"),
        (b"<sdf/>", "SDF"),
        (b'<!DOCTYPE r [<!ENTITY x "y">]><robot name="a"><link name="b"/></robot>', "entities"),
    ],
)
def test_what_is_no_urdf_is_refused(text, words):
    with pytest.raises(SourceError) as caught:
        parse(text, "r.urdf")
    assert words in str(caught.value)
    assert caught.value.where == "r.urdf"


def test_a_meshs_key_tells_file_scale_and_colour_apart_and_nothing_else():
    def key(filename: str = "a/Mesh 1.stl", scale: str = "1 1 1", more: str = "") -> str:
        (shape,) = read(visual(f'<mesh filename="{filename}" scale="{scale}"/>', more)).links[0].visuals
        return mesh_key(shape)

    red = '<material><color rgba="1 0 0 1"/></material>'
    assert key().startswith("Mesh_1-")
    assert key() == key(more='<origin xyz="1 2 3"/>')
    assert len({key(), key("b/Mesh 1.stl"), key(scale="1 1 -1"), key(more=red)}) == 4
