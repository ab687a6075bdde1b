"""MJCF as a source: what MuJoCo compiles is what we build, by MuJoCo and by Pinocchio."""

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats.mjcf.model import Mjcf
from linkwright.stages.graph import build_robot
from linkwright.stages.graph.dofs import conjugate
from linkwright.stages.robot import codec
from linkwright.stages.robot.bundle import FileBundle
from linkwright.stages.robot.errors import AssemblyError, ProtocolError
from linkwright.stages.robot.model.robot import Limits, Spring
from linkwright.stages.robot.motion.kinematics import chain, link_poses
from linkwright.stages.robot.motion.start_pose import starting_point
from tests.fake_onshape.sample import sample_document
from tests.support.building import plan_of, write
from tests.support.building import robot_of as drawn_robot
from tests.support.cases import mostly_slow
from tests.support.checked import checked
from tests.support.engines import Mujoco, Pinocchio
from tests.support.mjcfs import Original, body, bundle_of, model, random_model, robot_of, written
from tests.support.reported import codes
from tests.support.robots import joint, loop, robot_with, some_values

pytestmark = pytest.mark.usefixtures("guests_at_home")

EXACT = 1e-9


def vars_of(value, names):
    return tuple(getattr(value, name) for name in names.split())


def agree(path, folder, **keys):
    """Our MJCF and URDF of a file move and weigh as the file itself, and pass every check. The MJCF has the
    file's frames; the URDF has each at its joint."""
    robot = robot_of(path, **keys)
    exported = write(robot, folder)
    start = starting_point(robot)
    engines = [
        (Mujoco(folder / "robot.xml", {dof.name: start[dof.name] for dof in robot.dofs}), Mujoco(path)),
        (Pinocchio(exported.files["robot.urdf"]), Original(path)),
    ]
    names = [dof.name for dof in robot.dofs]
    rng = np.random.default_rng(5)
    for _ in range(3):
        q = some_values(robot, rng)
        for engine, original in engines:
            actual, wanted = engine.poses(q), original.poses(q)
            for link in robot.links:
                np.testing.assert_allclose(actual[link.name], wanted[link.name], atol=EXACT)
            if names:
                for quantity in ("mass_matrix", "gravity"):
                    ours, theirs = (getattr(measured, quantity)(q, names) for measured in (engine, original))
                    np.testing.assert_allclose(ours, theirs, atol=EXACT)
    assert not [check for check in checked(folder, robot, plan_of()) if check.fails]
    return robot


@pytest.mark.parametrize("seed", mostly_slow(range(10), keep=4))
def test_any_tree_keeps_its_kinematics_mass_and_gravity(tmp_path, seed):
    agree(written(tmp_path, random_model(seed)), tmp_path / "out")


HIP = body(
    "leg",
    '<joint name="yaw" axis="0 0 1" pos=".1 0 0" range="-30 30" ref="10"/>'
    '<joint name="roll" axis="1 0 0" class="weak"/>'
    '<joint name="pitch" axis="0 1 1" pos="0 .1 0"/>'
    + body("foot", '<joint name="ankle" type="ball" pos=".02 0 .1" range="0 40"/>', pos="0 0 -.4"),
    pos="0 .1 -.1",
    euler="10 20 30",
    childclass="strong",
)
DEFAULTS = """<default><joint damping="1"/><default class="strong"><joint armature=".2" damping="2"/>
    <default class="weak"><joint frictionloss=".3"/></default></default></default>"""


def test_three_hinges_in_one_body_are_one_joint_of_three_dofs(tmp_path):
    path = written(tmp_path, model(body("trunk", HIP), DEFAULTS, compiler=""))
    robot = agree(path, tmp_path / "out")
    leg, ankle = robot.joints
    assert (leg.name, leg.type, leg.child) == ("leg_joints", "compound", "leg")
    dynamics = [(dof.name, *vars_of(dof.dynamics, "damping armature friction")) for dof in leg.dofs]
    assert dynamics == [("yaw", 2.0, 0.2, None), ("roll", 2.0, 0.2, 0.3), ("pitch", 2.0, 0.2, None)]
    assert leg.dofs[0].limits == Limits(*np.radians([-30, 30]))
    assert leg.dofs[0].saved == pytest.approx(np.radians(10))
    assert (ankle.type, ankle.dofs[0].limits) == ("ball", Limits())
    ours = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "robot.xml"))
    np.testing.assert_allclose(ours.joint("ankle").range, np.radians([0, 40]), atol=EXACT)


def test_a_links_frame_is_that_of_its_joint(tmp_path):
    inside = '<joint name="hinge" axis="0 0 1" pos=".1 .2 .3"/><site name="tip" pos=".1 .2 .4"/>'
    robot = robot_of(written(tmp_path, model(body("base", body("arm", inside, pos="0 0 1")))))
    np.testing.assert_allclose(robot.joints[0].parent_from_joint[:3, 3], [0.1, 0.2, 1.3], atol=1e-15)
    np.testing.assert_allclose(robot.frames[0].link_from_frame[:3, 3], [0, 0, 0.1], atol=1e-15)
    np.testing.assert_allclose(robot.link("arm").inertial.com, [-0.09, -0.22, -0.27], atol=1e-15)


@pytest.mark.parametrize(
    ("world", "root", "fixed", "joints"),
    [
        (body("base"), "base", True, []),
        (body("base", pos="0 0 .1"), "world", True, [("base_fixed", "fixed")]),
        (body("base", "<freejoint/>", pos="0 0 .5"), "base", False, []),
        (body("base", '<joint name="swing"/>'), "world", True, [("swing", "revolute")]),
        (body("a", '<joint name="x"/>') + body("b", pos="1 0 0"), "world", True, [("x", 0), ("b_fixed", 0)]),
    ],
)
def test_the_world_holds_a_body_by_a_joint(tmp_path, world, root, fixed, joints):
    robot = robot_of(written(tmp_path, model(world)))
    assert (robot.root.name, robot.base.fixed) == (root, fixed)
    assert [joint.name for joint in robot.joints] == [name for name, _ in joints]


def test_a_base_may_float_off_the_origin_or_be_tilted(tmp_path):
    robot = robot_of(written(tmp_path, model(body("base", pos="0 0 .1"))), root={"base": "free"})
    assert (robot.root.name, robot.base.fixed) == ("base", False)
    assert robot.world_from_root[2, 3] == pytest.approx(0.1)
    arm = body("arm", '<joint name="hinge" axis="1 0 0"/>')
    agree(written(tmp_path, model(body("base", arm, euler="1 .5 0"))), tmp_path / "out")


FOLLOW = """<equality><joint name="second" joint1="b" joint2="a" polycoef=".1 -2 0 0 0"/>
    <joint name="third" joint1="c" joint2="b" polycoef="0 .5 0 0 0"/>
    <joint name="bent" joint1="d" joint2="a" polycoef="0 1 1 0 0"/>
    <joint name="stuck" joint1="d"/></equality>"""


def following(folder):
    arms = (f'<joint name="{n}" ref=".{i + 1}" range="-9 9"/>' for i, n in enumerate("abcd"))
    return written(folder, model(body("base", "".join(map(body, ("A", "B", "C", "D"), arms))), FOLLOW))


def rules(robot):
    """follower → (driver, multiplier, offset)."""
    return {
        r.follower: (r.driver, pytest.approx(r.multiplier), pytest.approx(r.offset)) for r in robot.relations
    }


def test_joint_equalities_count_from_the_references(tmp_path):
    robot = agree(following(tmp_path), tmp_path / "out")
    # b − .2 = .1 − 2 (a − .1) and c − .3 = .5 (b − .2), so both by a.
    assert rules(robot) == {"b": ("a", -2.0, 0.5), "c": ("a", -1.0, 0.45)}
    saved = {dof.name: dof.saved for dof in robot.dofs}
    assert saved == pytest.approx({"a": 0.1, "b": 0.3, "c": 0.35, "d": 0.4})
    # What no relation is stays as it is; c follows a by b there, and a alone here.
    ours = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "robot.xml"))
    assert {ours.equality(index).name for index in range(ours.neq)} == {"second", "third", "bent", "stuck"}
    np.testing.assert_allclose(ours.equality("bent").data[:5], [0, 1, 1, 0, 0])
    chained = [diagnostic.where for diagnostic in robot.diagnostics if diagnostic.code == "W-MJCF-LEFT"]
    assert chained == ["third"]


def test_joint_equalities_obey_relations_too(tmp_path):
    path = following(tmp_path)
    for keys, expected in (
        ({"second": {"invert": True}}, {"b": ("a", 2.0, 0.5), "c": ("a", 1.0, 0.45)}),
        ({"second": {"offset": 0.1}}, {"b": ("a", -2.0, 0.1), "c": ("a", -1.0, 0.25)}),
        ({"third": {"drop": True}}, {"b": ("a", -2.0, 0.5)}),
        ({"*": {"drop": True}}, {}),
    ):
        assert rules(robot_of(path, relations=keys)) == expected, keys
    agree(path, tmp_path / "out", relations={"second": {"invert": True}})


def test_a_follower_of_two_relates_them_a_circle_is_refused(tmp_path):
    """b = .5 + 2 a and b = 3 c − .1, so that c = (.6 + 2 a) / 3: a drives both, as its relation is first."""
    arms = "".join(body(f"arm_{name}", f'<joint name="{name}" ref=".2"/>') for name in "abc")
    equality = """<equality><joint name="r1" joint1="b" joint2="a" polycoef=".7 2 0 0 0"/>
        <joint name="r2" joint1="b" joint2="c" polycoef=".3 3 0 0 0"/></equality>"""
    robot = agree(written(tmp_path, model(body("base", arms), equality)), tmp_path / "out")
    assert rules(robot) == {"b": ("a", 2.0, 0.5), "c": ("a", 2 / 3, 0.2)}
    assert [dof.saved for dof in robot.dofs] == pytest.approx([0.2, 0.9, 1 / 3])
    circle = equality.replace('joint1="b" joint2="c"', 'joint1="a" joint2="b"')
    with pytest.raises(AssemblyError, match="E-RELATION"):
        robot_of(written(tmp_path, model(body("base", arms), circle)))
    with pytest.raises(AssemblyError, match="E-SOURCE-KEY hidden"):
        robot_of(written(tmp_path, model(body("base"))), hidden="drop")


PIN, DRIVE, SWING = (f'<joint name="{name}" axis="0 0 1"/>' for name in ("pin", "drive", "swing"))
CRANK = body("crank", DRIVE + body("rod", PIN, pos=".1 0 0"))
FOURBAR = body("base", CRANK + body("rocker", SWING, pos="0 .2 0"))
TIES = 'name="loop" body1="rod" body2="rocker"'


@pytest.mark.parametrize(
    ("equality", "kind"),
    [
        (f'<connect {TIES} anchor=".1 .1 0"/>', "ball"),
        (f"<weld {TIES}/>", "fixed"),
        (f'<weld {TIES} relpose=".1 .2 .3 1 .2 0 0" anchor="1 2 3"/>', "fixed"),
    ],
)
def test_a_connect_and_a_weld_close_loops_where_mujoco_does(tmp_path, equality, kind):
    path = written(tmp_path, model(FOURBAR, f"<equality>{equality}</equality>"))
    robot = robot_of(path)
    (closed,) = robot.loops
    assert (closed.name, closed.type, {closed.link_a, closed.link_b}) == ("loop", kind, {"rod", "rocker"})
    if kind == "ball":
        write(robot, tmp_path / "out")
        names, q = [dof.name for dof in robot.dofs], np.random.default_rng(3).uniform(-1, 1, 3)
        ours, theirs = (violation(file, names, q) for file in (tmp_path / "out" / "robot.xml", path))
        assert np.linalg.norm(ours) == pytest.approx(np.linalg.norm(theirs), abs=EXACT)


def violation(path, names, values):
    """The rows of the equality constraints at these joint values."""
    compiled = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(compiled)
    for name, value in zip(names, values, strict=True):
        data.qpos[compiled.joint(name).qposadr[0]] = value
    mujoco.mj_forward(compiled, data)
    return np.array(data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY])


@pytest.mark.parametrize(
    "equality",
    [
        '<weld body1="a" body2="b" relpose=".1 .2 .3 1 .2 0 0" anchor="1 2 3"/>',
        '<weld body1="a" body2="b" anchor="1 2 3"/>',
        '<weld body1="b" relpose=".1 .2 .3 1 .2 0 0"/>',
        '<weld site1="p" site2="q"/>',
        '<connect body1="a" body2="b" anchor=".3 .2 .1"/>',
    ],
)
def test_a_closure_is_closed_where_mujoco_sees_no_violation(tmp_path, equality):
    sites = '<site name="{}" pos=".1 .3 .2" quat="1 2 {} 4"/>'
    world = body("a", sites.format("p", 3), pos="1 2 3", quat="4 3 2 1")
    world += body("b", "<freejoint/>" + sites.format("q", 5), pos="1 1 1")
    path = written(tmp_path, model(world, f"<equality>{equality}</equality>"))
    bundle = bundle_of(path)
    (closure,) = codec.load(Mjcf, bundle.body(bundle.definition)).closures
    compiled = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(compiled)
    mujoco.mj_forward(compiled, data)
    assert np.abs(data.efc_pos).max() > 0.1 or ("relpose" not in equality and "site" not in equality)
    where = {1: np.eye(4), 0: np.eye(4)}
    where[1][:3, :3], where[1][:3, 3] = data.xmat[1].reshape(3, 3), data.xpos[1]
    frames = dict(zip(closure.bodies, (closure.a_from_frame, closure.b_from_frame), strict=True))
    (still,) = set(closure.bodies) - {2}
    pose = where[still] @ frames[still] @ np.linalg.inv(frames[2])
    data.qpos[:3] = pose[:3, 3]
    mujoco.mju_mat2Quat(data.qpos[3:], pose[:3, :3].ravel())
    mujoco.mj_forward(compiled, data)
    np.testing.assert_allclose(data.efc_pos, 0, atol=1e-12)


def test_equalities_cut_loops_or_tie_separate_bodies(tmp_path):
    """A fixed joint is the last that goes into a tree by itself, but an equality is later still."""
    tie = '<equality><connect name="tie" body1="{}" body2="{}" anchor="{}"/></equality>'
    inside = body("rod", body("plate", pos="0 0 .1"), pos=".1 0 0")
    world = body("base", body("crank", '<joint name="drive"/>' + inside))
    robot = robot_of(written(tmp_path, model(world, tie.format("plate", "base", "0 0 0"))))
    assert [loop.name for loop in robot.loops] == ["tie"]
    assert sorted(joint.name for joint in robot.joints) == ["drive", "plate_fixed", "rod_fixed"]
    world = body("a", "<freejoint/>") + body("b", "<freejoint/>", pos="1 0 0")
    robot = robot_of(written(tmp_path, model(world, tie.format("a", "b", ".5 0 0"))))
    assert [(joint.name, joint.type) for joint in robot.joints] == [("tie", "ball")]
    assert "W-MJCF-TREE" in codes(robot)


ACTUATED = """<actuator><motor joint="a" gear="10" ctrlrange="-2 2"/><position joint="b" forcerange="-3 5"/>
  <motor name="push" joint="c" gear="2"/></actuator><sensor><gyro name="imu" site="tip"/></sensor>
  <tendon><spatial name="cable"><site site="tip"/><site site="root"/></spatial></tendon>"""


def test_actuators_bound_efforts_and_all_else_stays(tmp_path):
    joints = "".join(
        body(f"arm_{name}", f'<joint name="{name}" {more}/>')
        for name, more in {"a": "", "b": "", "c": 'actuatorfrcrange="-7 7" stiffness="2"'}.items()
    )
    world = body("base", joints + '<site name="root"/><camera name="eye"/>') + '<light name="sun"/>'
    world = world.replace('<site name="root"/>', '<site name="root"/><site name="tip" pos="0 0 1"/>')
    robot = robot_of(written(tmp_path, model(world, ACTUATED)))
    assert {dof.name: dof.dynamics.effort for dof in robot.dofs} == {"a": 20.0, "b": 5.0, "c": 7.0}
    assert {dof.name: dof.spring for dof in robot.dofs} == {"a": None, "b": None, "c": Spring(2.0)}
    assert robot.mjcf is not None
    assert [(part.tag, part.children[0].name) for part in robot.mjcf.sections] == [("tendon", "cable")]
    assert [mount.element.name for mount in robot.mjcf.mounted] == ["eye"]
    assert [element.children[0].name for element in robot.mjcf.scene] == ["sun"]
    assert not [code for code in codes(robot) if code.endswith("MJCF-LEFT")]


@pytest.mark.skipif(not hasattr(mujoco.MjModel, "nactuator"), reason="an actuator has a single control")
def test_a_servo_after_two_controls_keeps_its_range(tmp_path):
    two = "".join(body(name, f'<joint name="{name}" range="-1 1"/>') for name in "ab")
    acting = (
        '<actuator><pid joint="a" kp="1"/><position name="b" joint="b" kp="7" ctrlrange="-.7 .7"/></actuator>'
    )
    robot = robot_of(written(tmp_path, model(body("base", two), acting)))
    (servo,) = robot.actuators
    assert (servo.name, servo.control) == ("b", (-0.7, 0.7))


def same(robot, again):
    """The same links, joints, limits, relations, loops and frames, moving in the same way."""
    assert {link.name for link in again.links} == {link.name for link in robot.links}
    for kind in ("joints", "loops"):
        types = ({x.name: x.type for x in getattr(r, kind) if x.type != "fixed"} for r in (robot, again))
        assert next(types) == next(types)
    assert {f.name: f.link for f in again.frames} == {f.name: f.link for f in robot.frames}
    limits = {dof.name: dof.limits for dof in again.dofs if dof.kind != "ball"}
    for dof in robot.dofs:
        if dof.kind != "ball":
            wanted, ours = ((pair.lower, pair.upper) for pair in (dof.limits, limits[dof.name]))
            assert ours == tuple(end if end is None else pytest.approx(end, abs=EXACT) for end in wanted)
    assert rules(again) == rules(robot)
    start = starting_point(robot)
    q = some_values(robot, np.random.default_rng(8))
    q_again = {dof.name: since(dof, start[dof.name], q[dof.name]) for dof in robot.dofs}
    poses, poses_again = link_poses(robot, q), link_poses(again, q_again)
    for link in robot.links:
        np.testing.assert_allclose(poses_again[link.name], poses[link.name], atol=EXACT)
        own, other = link.inertial, again.link(link.name).inertial
        assert other.mass == pytest.approx(own.mass)
        np.testing.assert_allclose(other.com, own.com, atol=EXACT)
        np.testing.assert_allclose(other.inertia, own.inertia, atol=EXACT)


def since(dof, start, value):
    """A ball's value counted from qpos0, as MuJoCo has it."""
    if dof.kind != "ball":
        return value
    turned = chain([dof], {dof.name: conjugate(start)}) @ chain([dof], {dof.name: value})
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, turned[:3, :3].ravel())
    return tuple(quat)


EVERY_MATE = ("revolute", "prismatic", "cylindrical", "ball", "planar", "pin_slot", "parallel")


@pytest.mark.parametrize("turned", [False, True])
def test_the_sample_and_every_mate_read_back_are_themselves(tmp_path, turned):
    """All away from zero, which the loop that is open there asks for."""
    if turned:
        sample = drawn_robot(sample_document())
        write(sample, tmp_path)
        same(sample, robot_of(tmp_path / "robot.xml"))
    rng = np.random.default_rng(2)
    names = ["base", *EVERY_MATE]
    joints = []
    for parent, kind in zip(names, EVERY_MATE, strict=False):
        saved = [0.3, -0.2, 0.1, 0.4][
            : {"planar": 3, "parallel": 4, "cylindrical": 2, "pin_slot": 2}.get(kind, 1)
        ]
        if kind == "ball":
            saved = [(0.8, 0.0, 0.6, 0.0)]
        place = np.eye(4)
        place[:3, 3] = rng.uniform(-0.3, 0.3, 3)
        joints.append(joint(kind, parent, kind, saved, place=place, backwards=turned))
    bare = robot_with(joints, fixed=True)
    poses = link_poses(bare, {dof.name: dof.saved for dof in bare.dofs})
    ends = np.linalg.inv(poses["parallel"]), np.linalg.inv(poses["base"])
    closed = loop("revolute", "parallel", "base", *ends, [0.0])
    robot = robot_with(joints, loops=[closed], fixed=True)
    assert starting_point(robot)["revolute_joint"] == 0.3
    write(robot, tmp_path)
    again = robot_of(tmp_path / "robot.xml")
    same(robot, again)
    several = [joint for joint in again.joints if len(joint.dofs) > 1]
    assert len(several) == 4
    assert {joint.backwards for joint in several} == {turned}


@pytest.mark.parametrize(
    "change",
    [
        lambda text: b"[]",
        lambda text: b"{}",
        lambda text: text.replace(b'"parent": 1', b'"parent": 9'),
        lambda text: text.replace(b'"mass": 1.0', b'"mass": null'),
        lambda text: b"\xff\xfe",
    ],
)
def test_a_bundle_that_holds_no_model_is_refused(tmp_path, change):
    bundle = bundle_of(written(tmp_path, model(body("base", HIP), DEFAULTS, compiler="")))
    body_of_it = change(bundle.body(bundle.definition))
    forged = FileBundle("mjcf", bundle.root, "d", {}, {"d": body_of_it})
    with pytest.raises((ProtocolError, AssemblyError)):
        build_robot(forged, plan_of())
