"""The reader of URDFs: what a file says, what it gets wrong, and what becomes of it."""

import json
import math

import numpy as np
import pytest

from linkwright.stages.formats.meshes.body_arrays import Body, encode
from linkwright.stages.formats.urdf.model import mesh_key
from linkwright.stages.formats.urdf.parse import parse
from linkwright.stages.graph import build_robot
from linkwright.stages.graph.urdf.inertias import nearest_physical
from linkwright.stages.graph.urdf.solid_inertia import solid_of
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.codec import decode_robot, encode_robot
from linkwright.stages.robot.dynamics.inertia import is_physical, primitive_inertial, principal
from linkwright.stages.robot.errors import AssemblyError
from linkwright.stages.robot.model.robot import Limits
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.support.building import plan_of, write
from tests.support.checked import checked, failures
from tests.support.engines import Pinocchio
from tests.support.pinocchio import pin
from tests.support.reported import only, reports
from tests.support.urdfs import parity, same_bounds, urdf_bundle, urdf_robot

BODY = '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
LIMIT = '<limit lower="-1" upper="2" effort="3" velocity="4"/>'


def link(name, inside=BODY):
    return f'<link name="{name}">{inside}</link>'


def joint(name, parent, child, kind="revolute", inside=LIMIT):
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}<axis xyz="0 0 1"/>{inside}</joint>'


def robot_text(*pieces):
    return f'<robot name="r">{"".join(pieces)}</robot>'


def inertial(mass, *moments):
    tensor = " ".join(f'i{axis}{axis}="{moment}"' for axis, moment in zip("xyz", moments, strict=True))
    return f'<inertial><mass value="{mass}"/><inertia {tensor} ixy="0" ixz="0" iyz="0"/></inertial>'


def pair(second=BODY, *, kind="revolute", inside=LIMIT):
    """Two links, a and b, on a joint j."""
    return robot_text(link("a"), link("b", second), joint("j", "a", "b", kind, inside))


def three(**follow):
    """A driver, and a joint that follows it with these attributes of its <mimic>."""
    text = " ".join(f'{key}="{value}"' for key, value in follow.items())
    return robot_text(
        *map(link, "abc"),
        joint("drive", "a", "b"),
        joint("follow", "b", "c", inside=f'{LIMIT}<mimic joint="drive" {text}/>'),
    )


def made(robot, bundle=None):
    return make_geometry(robot, bundle or urdf_bundle(b""), plan_of(), lambda kind, key, make: make())


def codes(robot):
    """The diagnostics, but the one that nearly every URDF gets: that its base may be fixed."""
    return [diagnostic.code for diagnostic in robot.diagnostics if diagnostic.code != "I-URDF-BASE"]


def refused(text, **keys):
    with pytest.raises(AssemblyError) as caught:
        urdf_robot(text, plan_of(**keys))
    return [(problem.code, problem.where) for problem in caught.value.problems]


def test_everything_that_is_no_tree_is_reported_at_once():
    ends = ("twice ab", "again cb", "self ff", "round de", "and_round ed")
    joints = (joint(name, *both) for name, both in map(str.split, ends))
    text = robot_text(*map(link, "abcdef"), joint("lost", "a", "nowhere"), *joints)
    assert refused(text) == [
        ("E-URDF-CYCLE", "and_round, round"),
        ("E-URDF-LINK", "lost"),
        ("E-URDF-PARENTS", "b"),
        ("E-URDF-ROOTS", "r"),
        ("E-URDF-SELF", "self"),
    ]


def test_several_roots_may_be_welded():
    text = robot_text(*map(link, "abc"), joint("j", "a", "b"))
    robot = urdf_robot(text, plan_of(root={"disconnected": "weld"}))
    assert [joint.type for joint in robot.joints] == ["revolute", "fixed"]


def test_a_loose_tree_keeps_its_own_root():
    joints = (joint(name, *ends) for name, *ends in (("h", "trunk", "leg"), ("k", "leg", "foot")))
    links = map(link, ("trunk", "leg", "foot", "base", "arm"))
    text = robot_text(*links, *joints, joint("j", "base", "arm"))
    robot = urdf_robot(text, plan_of(root={"disconnected": "weld"}))
    ends = {joint.name: (joint.parent, joint.child) for joint in robot.joints}
    assert ends["j"] == ("base", "arm")
    assert ends["base_fixed"] == ("trunk", "base")


def test_mimics_that_follow_nothing():
    drivers = {"own": "own", "none": "nothing", "rigid": "fix", "one": "two", "two": "one"}
    text = robot_text(
        *(link(name) for name in ("a", "fix", *(f"{name}_link" for name in drivers))),
        *(
            joint(name, "a", f"{name}_link", inside=f'{LIMIT}<mimic joint="{driver}"/>')
            for name, driver in drivers.items()
        ),
        joint("fix", "a", "fix", "fixed", ""),
    )
    assert refused(text) == [("E-URDF-MIMIC", name) for name in ("none", "one", "own", "rigid", "two")]


def test_mimics_are_flattened_with_their_offsets_as_they_are():
    first = f'{LIMIT}<mimic joint="drive" multiplier="-2" offset="4"/>'
    second = f'{LIMIT}<mimic joint="follow" multiplier="0.5" offset="1e-7"/>'
    text = robot_text(
        *map(link, "abcd"),
        joint("drive", "a", "b"),
        joint("follow", "b", "c", "prismatic", first),
        joint("last", "c", "d", "continuous", second),
    )
    robot = urdf_robot(text)
    relations = {relation.follower: relation for relation in robot.relations}
    assert {name: (r.driver, r.multiplier, r.offset) for name, r in relations.items()} == {
        "follow": ("drive", -2.0, 4.0),
        "last": ("drive", -1.0, 2.0 + 1e-7),
    }
    assert [dof.saved for dof in robot.dofs] == [0.0, 4.0, 2.0 + 1e-7]
    assert "W-RELATION-OFFSET" not in codes(robot)


def test_the_files_of_a_mimic_with_an_offset_pass(tmp_path):
    text = three(offset="0.5").encode()
    robot = urdf_robot(text)
    assert failures(tmp_path, robot) == []
    files = write(robot, tmp_path).files
    assert parity(text, robot, files, tmp_path).worst < 1e-11
    assert not same_bounds(text, robot, files["robot.urdf"])


@pytest.mark.parametrize(
    ("keys", "rule", "saved"),
    [
        ({}, (0.8, 0.5), 0.5), ({"invert": True}, (-0.8, 0.5), 0.5), ({"offset": -0.25}, (0.8, -0.25), -0.25),
        ({"invert": True, "offset": 0}, (-0.8, 0.0), 0.0), ({"drop": True}, None, 0.5),
    ],
)  # fmt: skip
def test_mimics_of_a_file_obey_relations_too(keys, rule, saved, tmp_path):
    robot = urdf_robot(three(multiplier="0.8", offset="0.5"), plan_of(relations={"follow*": keys}))
    relations = [(relation.multiplier, relation.offset) for relation in robot.relations]
    assert relations == ([rule] if rule else [])
    assert robot.dofs[1].saved == saved
    assert not [code for code in codes(robot) if "RELATION" in code]
    assert failures(tmp_path, robot) == []


def test_dummies_become_frames_with_all_that_hangs_on_them():
    box = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    shift = '<origin xyz="0 0 1"/>'
    text = robot_text(
        link("a"),
        link("frame", box),
        link("point", inertial(1e-3, 0, 0, 0)),
        link("b"),
        joint("f", "a", "frame", "fixed", f'<origin xyz="0 0 1" rpy="0 {math.pi / 2} 0"/>'),
        joint("p", "frame", "point", "fixed", shift),
        joint("j", "point", "b", "revolute", shift + LIMIT),
    )
    robot = urdf_robot(text)
    assert [link.name for link in robot.links] == ["a", "b"]
    # The first turns z to x.
    places = {frame.name: (frame.link, *frame.link_from_frame[:3, 3].round(12)) for frame in robot.frames}
    assert places == {"frame": ("a", 0, 0, 1), "point": ("a", 1, 0, 1)}
    assert np.allclose(robot.joints[0].parent_from_joint[:3, 3], [2, 0, 1], atol=1e-15)
    assert [shape.link_from_shape[2, 3] for shape in robot.root.shapes] == [1.0]
    assert robot.root.inertial.mass == 2.001
    assert np.allclose(robot.root.inertial.com, np.array([1, 0, 1]) * 1e-3 / 2.001, atol=1e-15)
    assert "I-URDF-FRAME" in codes(robot)


def test_links_without_mass_that_carry_others_get_next_to_none():
    text = robot_text(
        *(link("a"), link("between", ""), link("b"), link("tip", "")),
        *(joint("x", "a", "between"), joint("y", "between", "b"), joint("z", "b", "tip")),
    )
    assert refused(text) == [("E-MASS", "tip")]
    robot = urdf_robot(text, policy="project")
    assert [robot.link(name).inertial.mass for name in ("between", "tip")] == [1e-12, 1e-12]
    assert {"I-URDF-MASSLESS", "W-URDF-MASSLESS"} <= set(codes(robot))


@pytest.mark.parametrize("moments", [(1, 1, 3), (0, 1, 1), (-1, 2, 2)])
def test_an_inertia_that_no_solid_has_is_refused_or_projected(moments):
    text = pair(inertial(1.0, *moments))
    assert refused(text) == [("E-INERTIA", "b")]
    robot = urdf_robot(text, policy="project")
    projected = robot.link("b").inertial
    assert is_physical(projected)
    assert (projected.mass, codes(robot)) == (1.0, ["W-INERTIA"])
    assert np.allclose(projected.inertia, nearest_physical(np.diag(moments)), atol=1e-15)


def test_the_nearest_inertia_changes_nothing_but_what_must():
    # S = ½ tr(I) 1 − I = diag(1.5, 1.5, −0.5): the last goes to a millionth of the largest.
    thin, possible = 1.5e-6, np.diag([1.0, 1.5, 2.0])
    nearest = nearest_physical(np.diag([1.0, 1.0, 3.0]))
    assert np.allclose(nearest, np.diag([1.5 + thin, 1.5 + thin, 3.0]), atol=1e-15)
    assert np.allclose(nearest_physical(possible), possible, atol=1e-15)


@pytest.mark.parametrize("where", ["visual", "collision"])
def test_an_inertia_made_again_is_that_of_the_even_solid(where):
    box = f'<{where}><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.4 0.6"/></geometry></{where}>'
    again = urdf_robot(pair(box + inertial(3.0, 1, 1, 3)), policy="recompute").link("b").inertial
    assert np.allclose(again.com, [0.1, 0, 0], atol=1e-15)
    assert np.allclose(again.inertia, primitive_inertial("box", (0.2, 0.4, 0.6), 3.0).inertia, atol=1e-14)


def test_an_open_mesh_weighs_as_its_hull():
    mesh = '<visual><geometry><mesh filename="m.stl"/></geometry></visual>'
    shape = parse(robot_text(link("a", mesh)).encode(), "r").links[0].visuals[0]
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5]], dtype=np.int32)
    body = Body(mesh_key(shape), corners, faces, ((1.0, 0.0, 0.0, 1.0),), np.zeros(4, dtype=np.uint16))
    bundle = urdf_bundle(b"", meshes={mesh_key(shape): encode([body])})
    solid = solid_of([shape], bundle)
    assert solid is not None
    assert math.isclose(solid.mass, 1.0)
    assert np.allclose(solid.com, 0.5)
    assert np.allclose(solid.inertia, np.eye(3) / 6)
    assert solid_of([], bundle) is None


def test_a_mass_below_zero_and_an_inertia_without_mass():
    text = robot_text(
        *(link("a"), link("minus", inertial(-1, 1, 1, 1)), link("light", inertial(0, 1, 1, 1))),
        *(joint("j", "a", "minus", "fixed", ""), joint("k", "a", "light", "fixed", "")),
    )
    moving = text.replace('name="k" type="fixed"', 'name="k" type="continuous"')
    assert refused(moving) == [("E-INERTIA", "light"), ("E-INERTIA", "minus"), ("E-MASS", "light")]
    # What does not move needs no mass.
    assert refused(text) == [("E-INERTIA", "minus")]
    assert sum(link.inertial.mass for link in urdf_robot(text, policy="recompute").links) == 2.0
    assert only(urdf_robot(text.replace('value="-1"', 'value="1"')), "W-INERTIA").where == "light"


@pytest.mark.parametrize("turn", ["0 0 0", "0.3 0.4 0.5", "1 2 3", "0.1 0 0.7"])
def test_a_flat_body_is_on_the_edge_and_still_loads(turn, tmp_path):
    # A + B = C to the last digits, where rounding decides: MuJoCo refuses one digit beyond.
    flat = inertial(1, 0.1, 0.2, 0.30000000000000004).replace("<mass", f'<origin rpy="{turn}"/><mass')
    robot = urdf_robot(robot_text(link("a", flat)))
    assert failures(tmp_path, robot) == []
    assert np.abs(principal(robot.root.inertial.inertia) - [0.1, 0.2, 0.3]).max() < 1e-11


def test_limits_as_in_ros():
    text = robot_text(
        *map(link, "abcdef"),
        joint("free", "a", "b", "continuous", '<limit effort="1" velocity="1"/>'),
        joint("open", "a", "c", "revolute", '<limit effort="0" velocity="1"/>'),
        joint("half", "a", "d", "prismatic", '<limit upper="0.5" effort="1" velocity="0"/>'),
        joint("lacks", "a", "e", "revolute", ""),
        joint("plain", "a", "f"),
    )
    robot = urdf_robot(text)
    dofs = {dof.name: dof for dof in robot.dofs}
    limits = {name: (dof.limits.lower, dof.limits.upper) for name, dof in dofs.items()}
    none = (None, None)
    assert limits == {"free": none, "open": none, "half": (0.0, 0.5), "lacks": none, "plain": (-1.0, 2.0)}
    assert (dofs["open"].dynamics.effort, dofs["half"].dynamics.velocity) == (None, None)
    bounds = {("W-URDF-RANGE", "open"), ("W-URDF-BOUND", "open"), ("W-URDF-BOUND", "half")}
    assert bounds | {("W-LIMIT", "lacks")} <= set(reports(robot))
    assert ("W-LIMIT", "free") not in reports(robot)
    crossed = pair(inside='<limit lower="2" upper="-1" effort="1" velocity="1"/>')
    assert refused(crossed) == [("E-URDF-LIMIT", "robot.urdf, line 1")]


@pytest.mark.parametrize(
    ("base", "top", "reported"),
    [("auto", "a", True), ("fixed", "a", False), ("free", "a", False), ("auto", "world", False)],
)
def test_a_base_that_nobody_fixes_is_said_to_be_free(base, top, reported):
    text = robot_text(link(top, "" if top == "world" else BODY), link("b"), joint("j", top, "b"))
    robot = urdf_robot(text, plan_of(root={"base": base}))
    hints = [(note.where, note.hint) for note in robot.diagnostics if note.code == "I-URDF-BASE"]
    assert hints == ([(top, "if it is fixed to the ground: root=fixed")] if reported else [])
    assert robot.base.fixed == (base == "fixed" or top == "world")


def test_a_zero_outside_of_the_limits_is_no_ones_pose():
    robot = urdf_robot(pair(inside='<limit lower="1" upper="2" effort="1" velocity="1"/>'))
    assert (codes(robot), robot.dofs[0].limits) == ([], Limits(1.0, 2.0))


BOX = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
ARM = (link("a"), link("b"), joint("j", "a", "b"))
HELD = joint("hold", "world", "a", "fixed", "")


@pytest.mark.parametrize(
    ("name", "pieces"),
    [
        ("world", (link("world", BOX), *ARM, HELD)),
        ("foot", (link("foot", BOX), link("a"), joint("f", "foot", "a", "fixed", ""))),
    ],
)
def test_a_root_without_mass_stays_and_weighs_nothing(name, pieces, tmp_path):
    robot = urdf_robot(robot_text(*pieces))
    assert (robot.root.name, robot.base.fixed) == (name, name == "world")
    write(robot, tmp_path, geometry=made(robot))
    assert not [check for check in checked(tmp_path, robot, plan_of()) if check.fails]


def test_a_world_with_mass_is_a_link_as_any():
    heavy = urdf_robot(robot_text(link("world"), *ARM, HELD))
    assert (heavy.root.name, heavy.base.fixed) == ("world_link", False)


def test_a_planar_joint_slides_across_its_axis(tmp_path):
    text = pair(kind="planar", inside='<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>')
    robot = urdf_robot(text)
    assert [dof.name for dof in robot.dofs] == ["j_x", "j_y", "j_turn"]
    model = pin.buildModelFromXML(text)
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.array([0.3, -0.4, math.cos(0.7), math.sin(0.7)]))
    expected = data.oMf[model.getFrameId("b", pin.FrameType.BODY)].homogeneous
    q = {"j_x": 0.3, "j_y": -0.4, "j_turn": 0.7}
    assert np.abs(link_poses(robot, q)["b"] - expected).max() < 1e-14
    assert failures(tmp_path, robot) == []
    ours = Pinocchio((tmp_path / "robot.urdf").read_bytes())
    assert np.abs(ours.poses(q)["b"] - expected).max() < 1e-11


@pytest.mark.parametrize("axis", [(0, 0, -1), (1, 0, 0), (0, 0.6, -0.8), (1e-9, 0, -1)])
def test_a_plane_has_its_own_axes(axis):
    robot = urdf_robot(pair(kind="planar", inside="").replace("0 0 1", " ".join(map(str, axis))))
    frame = np.column_stack([dof.axis for dof in robot.dofs])
    assert np.allclose(frame.T @ frame, np.eye(3), atol=1e-15)
    assert np.isclose(np.linalg.det(frame), 1.0)
    assert np.allclose(frame[:, 2], np.array(axis) / np.linalg.norm(axis), atol=1e-15)


def test_a_floating_link_floats_from_the_root(tmp_path):
    afloat = joint("drift", "world", "a", "floating", '<origin xyz="0 0 1"/>')
    robot = urdf_robot(robot_text(link("world", ""), *ARM, afloat))
    assert [joint.type for joint in robot.joints] == ["free", "revolute"]
    assert failures(tmp_path, robot) == []
    deep = robot_text(*ARM, link("c"), joint("d", "b", "c", "floating", ""))
    assert refused(deep) == [("E-FLOATING", "d")]


def test_meshes_are_parts_that_are_seen_or_collide():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.int32)
    shown = '<visual><geometry><mesh filename="v.stl"/></geometry></visual>'
    far = '<origin xyz="0 0 5"/>'
    hit = f'<collision>{far}<geometry><mesh filename="c.stl" scale="2 2 2"/></geometry></collision>'
    text = robot_text(link("a", BODY + shown + hit), link("b", BODY + shown), joint("j", "a", "b")).encode()
    first, red = parse(text, "r").links[0], ((1.0, 0.0, 0.0, 1.0),)
    bodies = {
        key: encode([Body(key, corners * scale, faces, red, np.zeros(4, dtype=np.uint16))])
        for key, scale in zip(map(mesh_key, (*first.visuals, *first.collisions)), (1, 2), strict=True)
    }
    bundle = urdf_bundle(text, meshes=bodies)
    robot = decode_robot(encode_robot(build_robot(bundle, plan_of())))
    assert [(part.collides, part.seen) for part in robot.root.parts] == [(True, False), (False, True)]
    assert robot.root.parts[0].path == ("a", "collision", "1")
    geometry = made(robot, bundle)
    assert [(s.link, s.role, s.volume) for s in geometry.shapes] == [
        ("a", "collision", pytest.approx(8 / 6)),
        *((link, role, pytest.approx(1 / 6)) for link, role in (("a", "visual"), ("b", "collision"))),
        ("b", "visual", pytest.approx(1 / 6)),
    ]
    assert not geometry.diagnostics


def test_transmissions_are_kept_by_the_names_of_joints(tmp_path):
    drive = (
        '<transmission name="t"><type>transmission_interface/SimpleTransmission</type>'
        '<joint name="l.j"><hardwareInterface>EffortJointInterface</hardwareInterface></joint>'
        '<actuator name="m"><mechanicalReduction>50</mechanicalReduction></actuator></transmission>'
    )
    robot = urdf_robot(robot_text(link("a"), link("b"), joint("l.j", "a", "b"), drive))
    (transmission,) = robot.transmissions
    assert (transmission.name, transmission.joint) == ("t", "l.j")
    assert (transmission.reduction, transmission.interfaces) == (50.0, ("EffortJointInterface",))
    table = json.loads(write(robot, tmp_path).files["robot.json"])
    assert [entry["joint"] for entry in table["transmissions"]] == ["l.j"]


def test_keys_about_assemblies_are_refused_by_name():
    text = robot_text(link("a"))
    problems = refused(text, mirror="weld", depth={"max": 0}, mass={"parts": {"x": {"mass": 1}}})
    assert problems == [("E-SOURCE-KEY", key) for key in ("depth", "mass.parts", "mirror")]


def test_a_mass_of_the_users_own_resolves_an_inertia():
    text = robot_text(link("a", inertial(1.0, 1, 1, 3)))
    mass = {"links": {"a": {"inertia": [1, 1, 1.5, 0, 0, 0]}}}
    assert urdf_robot(text, plan_of(mass=mass)).root.inertial.inertia[2, 2] == 1.5
