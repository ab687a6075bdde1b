"""USD of every kind of joint, loop and shape, as an independent reader has it."""

import importlib.util
import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest

from linkwright.pipeline.run.preflight import plan_problems
from linkwright.stages.robot.dynamics.mass_matrix import mass_matrix
from linkwright.stages.robot.model.poses import from_parts, inverse
from linkwright.stages.robot.model.robot import (
    Actuator,
    Dynamics,
    Frame,
    Inertial,
    Keyframe,
    Limits,
    Relation,
    frozen,
)
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from linkwright.stages.robot.motion.start_pose import home
from tests.support.building import NO_MESHES, plan_of
from tests.support.engines import Pinocchio
from tests.support.exports import exported, losses_of
from tests.support.places import PROJECT
from tests.support.robots import (
    EVERY,
    LOOPS,
    at,
    joint,
    loop,
    pose,
    robot_around,
    robot_with,
    some_values,
)
from tests.support.usd import Usd, complaints, parsed, pxr, stage_of

pytestmark = pytest.mark.usefixtures("no_thumbnails")

TOLERANCE = 1e-5
"""The tolerance of single precision, for robots of about a metre."""

GROUND = {"ground": {"kind": "none"}}
"""Without one the robot's root is at the origin."""


def usd_export(robot, geometry=NO_MESHES, **keys):
    assert pxr.Usd
    keys = {"export": {"usd": {}, "urdf": {}}} | GROUND | keys
    return exported(robot, geometry, **keys)


def read(folder, robot, geometry=NO_MESHES, **keys):
    stage = stage_of(usd_export(robot, geometry, **keys).files, folder)
    assert complaints(stage) == []
    return Usd(stage)


def losses(robot, geometry=NO_MESHES, **keys):
    return losses_of(usd_export(robot, geometry, export={"usd": {}}, **keys), "robot.usda")


def simple(q):
    """The values of turns and slides: what engines know of the state of a USD. Every ball is at zero."""
    return {name: value for name, value in q.items() if not isinstance(value, tuple)}


@pytest.mark.parametrize("root", ["base", "world"])
@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kind", EVERY)
def test_links_are_where_kinematics_have_them_and_weigh_the_same(kind, backwards, root, tmp_path):
    rng = np.random.default_rng(EVERY.index(kind))
    robot = robot_around(kind, rng, root, backwards)
    files = usd_export(robot).files
    usd, by_urdf = Usd(stage_of(files, tmp_path)), Pinocchio(files["robot.urdf"])
    own = [dof.name for dof in robot.dofs if dof.kind != "free"]
    for _ in range(3):
        q = some_values(robot, rng)
        expected = link_poses(robot, q)
        free = {joint.child: expected[joint.child] for joint in robot.joints if joint.type == "free"}
        actual = usd.poses({name: value for name, value in q.items() if name in own}, free or None)
        for link in expected:
            assert np.abs(actual[link] - expected[link]).max() < TOLERANCE, link
        if kind != "free":
            mass = usd.mass_matrix(q, own)
            scale = max(1.0, np.abs(mass).max())
            assert np.abs(mass - mass_matrix(robot, q)).max() < TOLERANCE * scale
            assert np.abs(mass - by_urdf.mass_matrix(q, own)).max() < TOLERANCE * scale


@pytest.mark.parametrize("axis", [(0, 0, -1), (0, -1, 0), (-1, 0, 0), (0, 1, 0), (0.6, 0, -0.8)])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_axis_of_any_direction_is_one_of_the_frames(kind, axis, tmp_path):
    rng = np.random.default_rng(1)
    turned = joint(kind, "base", "one", place=pose(rng))
    robot = robot_with([replace(turned, dofs=(replace(turned.dofs[0], axis=frozen(np.array(axis, float))),))])
    usd = read(tmp_path, robot)
    for q in (-1.2, 0.7):
        expected = link_poses(robot, {"one_joint": q})["one"]
        assert np.abs(usd.poses({"one_joint": q})["one"] - expected).max() < TOLERANCE


def shut_by(kind, origins=()):
    """A planar and a ball joint whose end a loop `shut` of this type holds to the base: saved away from mate
    zero, where the loop is open. Returns the robot, and the loop's mate as a joint with its saved values."""
    rng = np.random.default_rng(LOOPS.index(kind))
    rows = [
        joint("planar", "base", "one", [0.2, -0.1, 0.4], place=pose(rng)),
        joint("ball", "one", "two", [(0.8, 0.6, 0.0, 0.0)], place=pose(rng)),
    ]
    tree, a_from_frame = robot_with(rows), pose(rng)
    mate = joint(kind, "base", "end", name="shut", origins=origins)
    values = {
        dof.name: (0.6, 0.0, 0.8, 0.0) if kind == "ball" else 0.3 * (index + 1)
        for index, dof in enumerate(mate.dofs)
    }
    end = link_poses(tree, saved_configuration(tree))["two"] @ a_from_frame
    across = link_poses(robot_with([mate]), values)["end"]
    shut = loop(kind, "two", "base", a_from_frame, end @ inverse(across), name="shut")
    dofs = tuple(replace(dof, saved=values[dof.name]) for dof in mate.dofs)
    return replace(tree, loops=(replace(shut, dofs=dofs),)), mate, values


KINDS = {"fixed": "Fixed", "revolute": "Revolute", "prismatic": "Prismatic", "ball": "Spherical"}


@pytest.mark.slow
@pytest.mark.parametrize("shifted", [False, True])
@pytest.mark.parametrize("kind", LOOPS)
def test_loop_of_any_type_is_a_joint_that_holds_as_its_mate(kind, shifted, tmp_path):
    robot, mate, values = shut_by(kind, [at(0.1, 0.2, 0.3)] * 3 if shifted else [])
    saved, (shut,) = saved_configuration(robot), robot.loops
    assert "I-USD-LOOP" not in losses(replace(robot, loops=()))
    lost = losses(robot)
    assert lost["I-USD-LOOP"].endswith(": shut")
    usd = read(tmp_path, robot)
    (name,) = usd.loops
    chained = shifted and len(mate.dofs) > 1
    assert chained or usd.loops[name].GetPrim().GetTypeName() == f"Physics{KINDS.get(kind, '')}Joint"
    assert chained == ("shut" in lost["I-USD-LOWERED"])
    # As the bodies stand, and by the joints.
    assert usd.gap(name, usd.stands) < TOLERANCE
    assert np.abs(usd.stands["two"] - link_poses(robot, saved)["two"]).max() < TOLERANCE
    by_joints = usd.poses(simple(saved | values))
    assert usd.gap(name, by_joints) < TOLERANCE
    # Every way in which the mate yields is free, and every other one is held.
    for free in () if chained else (*values, None):
        moved = dict(values)
        if free is not None:
            moved[free] = (0.0, 1.0, 0.0, 0.0) if kind == "ball" else moved[free] + 0.2
        end = shut.b_from_frame @ link_poses(robot_with([mate]), moved)["end"]
        tilt = pose(np.random.default_rng(1), 0.0)
        gaps = [
            usd.gap(name, {**by_joints, "two": end @ off @ np.linalg.inv(shut.a_from_frame)})
            for off in (np.eye(4), at(0.03, 0.03, 0.03), tilt)
        ]
        assert gaps[0] < TOLERANCE
        assert (gaps[1] > 1e-2, gaps[2] > 1e-2) == (kind != "parallel", kind != "ball")


def test_limits_of_a_loop_are_those_of_its_joint(tmp_path):
    robot = robot_with([joint("planar", "base", "one"), joint("ball", "one", "two")])
    limits = {"shut_x": Limits(-0.1, 0.2), "shut_turn": Limits(-1, 2)}
    shut = loop("planar", "two", "base", np.eye(4), np.eye(4), name="shut", limits=limits)
    x, *rest = shut.dofs
    shut = replace(shut, dofs=(replace(x, axis=frozen(-x.axis)), *rest))
    usd = read(tmp_path, replace(robot, loops=(shut,)))
    for name, expected in (("transX", [-0.2, 0.1]), ("rotZ", np.degrees([-1, 2]))):
        ends = [usd.value("shut", f"limit:{name}:physics:{end}") for end in ("low", "high")]
        assert ends == pytest.approx(expected)
    assert usd.value("shut", "limit:transY:physics:low") is None


def test_limits_dynamics_and_home_are_in_usds_units(tmp_path):
    dynamics = Dynamics(0.1, 0.2, 0.03, 4, 5)
    rows = [
        joint("revolute", "base", "one", [0.5], limits={"one_joint": Limits(-1, 2)}, dynamics=dynamics),
        joint("prismatic", "one", "two", [0.1], limits={"two_joint": Limits(None, 0.3)}, dynamics=dynamics),
        joint("ball", "two", "three", limits={"three_joint": Limits(None, 0.6)}, dynamics=dynamics),
        joint("revolute", "three", "four"),
    ]
    robot = robot_with(rows)
    usd = read(tmp_path, robot)
    assert usd.limits("one_joint") == pytest.approx((-1, 2))
    assert usd.limits("two_joint") == pytest.approx((-math.inf, 0.3))
    assert usd.limits("four_joint") == (-math.inf, math.inf)
    for key in ("coneAngle0Limit", "coneAngle1Limit"):
        assert usd.value("three_joint", f"physics:{key}") == pytest.approx(math.degrees(0.6))
    for name, axis, scale in (("one_joint", "angular", 180 / math.pi), ("two_joint", "linear", 1.0)):
        physx, position = f"physxJointAxis:{axis}", {"one_joint": 0.5, "two_joint": 0.1}[name]
        expected = {
            "newton:armature": 0.03, "newton:damping": 0.1 / scale, "newton:friction": 0.2,
            "newton:velocityLimit": 5 * scale, "physxJoint:armature": 0.03,
            "physxJoint:maxJointVelocity": 5 * scale, f"{physx}:armature": 0.03,
            f"{physx}:maxJointVelocity": 5 * scale, f"{physx}:viscousFrictionCoefficient": 0.1 / scale,
            f"{physx}:staticFrictionEffort": 0.2, f"{physx}:dynamicFrictionEffort": 0.2,
            f"drive:{axis}:physics:maxForce": 4, f"drive:{axis}:physics:stiffness": 0,
            f"state:{axis}:physics:position": position * scale,
        }  # fmt: skip
        assert {key: usd.value(name, key) for key in expected} == pytest.approx(expected)
        schemas = usd.schemas(usd.joints[name].GetPrim())
        for schema in ("NewtonJointAPI", "PhysxJointAPI", f"PhysxJointAxisAPI:{axis}"):
            assert schema in schemas
        assert {f"PhysicsJointStateAPI:{axis}", f"PhysicsDriveAPI:{axis}"} < set(schemas)
    assert losses(robot)["I-USD-BALL"].endswith("three_joint")


def test_ball_without_a_cone_is_at_zero_where_it_is_at_home(tmp_path):
    turned = (0.8, 0.0, 0.6, 0.0)
    rows = [joint("ball", "base", "one", [turned]), joint("ball", "one", "two", [turned])]
    rows[1] = joint("ball", "one", "two", [turned], limits={"two_joint": Limits(None, 2)})
    robot = robot_with(rows)
    files = usd_export(robot).files
    assert json.loads(files["robot.json"])["usd"] == {"zeros": {"one_joint": list(turned)}}
    usd, at_home = Usd(stage_of(files, tmp_path)), link_poses(robot, home(robot))
    assert np.abs(usd.poses({})["one"] - at_home["one"]).max() < TOLERANCE
    # The cone is about z of the joint's own zero.
    assert np.abs(usd.poses({"two_joint": turned})["two"] - at_home["two"]).max() < TOLERANCE
    lost = losses(robot)
    assert lost["I-USD-ZERO"].endswith(": one_joint")
    assert lost["I-USD-START"].endswith(": two_joint")


def test_actuators_are_drives_at_the_dof(tmp_path):
    rows = [joint("prismatic", "base", "link_0", [0.1], name="joint_0")]
    rows += [joint("revolute", "base", f"link_{n}", [0.4], name=f"joint_{n}") for n in range(1, 6)]
    actuators = (
        Actuator("slide", "joint_0", "position", kp=900, kv=30, force=(-7, 7), home=0.1),
        Actuator("geared", "joint_1", "position", gear=-2, kp=50, kv=3, force=(-6, 6), home=-0.8),
        Actuator("speed", "joint_2", "velocity", kv=8),
        Actuator("motor", "joint_3", "motor", gear=3, control=(-2, 2), home=0.3),
        Actuator("way", "joint_4", "intvelocity", kp=60, kv=2),
        Actuator("brake", "joint_5", "damper", kv=1, control=(0, 1)),
    )
    robot = replace(robot_with(rows), actuators=actuators)
    usd = read(tmp_path, robot)
    names = ("stiffness", "damping", "maxForce", "targetPosition")

    def drive(number, axis="angular"):
        return tuple(usd.value(f"joint_{number}", f"drive:{axis}:physics:{name}") for name in names)

    degree = math.pi / 180
    # What slides up bears its link, of which the actuator holds 7 N.
    assert robot.link("link_0").inertial.mass * 9.81 > 7
    assert drive(0, "linear") == pytest.approx((900, 30, 7, 0.1 + 7 / 900))
    assert drive(1) == pytest.approx((200 * degree, 12 * degree, 12, 0.4 / degree))
    assert (drive(2)[:2], drive(3)[:3]) == (pytest.approx((0, 8 * degree)), pytest.approx((0, 0, 6)))
    assert drive(4) == pytest.approx((60 * degree, 2 * degree, 1e9, 0.4 / degree))
    assert drive(5)[:3] == (0, 0, 1e9)
    assert losses(robot)["I-USD-ACTUATOR"].endswith(": brake")


def test_relations_are_mimics_of_newton_and_of_physx(tmp_path):
    rows = [
        joint("revolute", "base", "one", [0.2], place=at(1, 0, 0)),
        joint("revolute", "base", "two", [0.9]),
        joint("prismatic", "base", "three", [0.15]),
    ]
    relations = [
        Relation("Gear", "two_joint", "one_joint", 2.0, 0.5),
        Relation("Rack", "three_joint", "one_joint", 0.5, 0.05),
    ]
    robot = robot_with(rows, relations=relations)
    usd = read(tmp_path, robot)
    # q = multiplier · driver + offset, of degrees.
    assert usd.target("two_joint", "newton:mimicJoint") == "one_joint"
    coefficients = [usd.value("two_joint", f"newton:mimicCoef{n}") for n in (0, 1)]
    assert coefficients == pytest.approx([math.degrees(0.5), 2.0])
    schemas = usd.schemas(usd.joints["three_joint"].GetPrim())
    assert "NewtonMimicAPI" not in schemas
    # PhysX: q + gearing · reference + offset = 0, of degrees and metres.
    for name, expected in (("two_joint", math.degrees(0.9)), ("three_joint", 0.15)):
        assert "PhysxMimicJointAPI:rotZ" in usd.schemas(usd.joints[name].GetPrim())
        assert usd.target(name, "physxMimicJoint:rotZ:referenceJoint") == "one_joint"
        gearing, offset = (usd.value(name, f"physxMimicJoint:rotZ:{key}") for key in ("gearing", "offset"))
        assert expected + gearing * math.degrees(0.2) + offset == pytest.approx(0, abs=1e-5)
    assert losses(robot)["I-USD-MIMIC"].endswith(": three_joint")


@pytest.mark.parametrize("fixed", [True, False])
def test_articulation_begins_at_the_base_and_is_at_home(fixed, tmp_path):
    rows = [
        joint("cylindrical", "base", "one", [0.2, 0.4], place=pose(np.random.default_rng(3))),
        joint("ball", "one", "two", [(0.8, 0.0, 0.6, 0.0)]),
    ]
    named = (Keyframe("home", (("one_joint_turn", 0.7),)), Keyframe("up", ()))
    robot = replace(robot_with(rows, fixed=fixed), keyframes=named)
    usd = read(tmp_path, robot, scene={"pose": {"xyz": [1, 2, 3], "rpy": [0, 0, math.pi / 2]}})
    world = from_parts(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([1.0, 2, 3]))
    for link, value in link_poses(robot, home(robot)).items():
        assert np.abs(usd.stands[link] - world @ value).max() < 1e-9, link
    for body, value in usd.poses(simple(home(robot))).items():
        assert np.abs(usd.stands[body] - value).max() < TOLERANCE, body
    (root,) = usd.roots
    expected = ("root_joint", "PhysicsFixedJoint") if fixed else ("base", "Xform")
    assert (root.GetName(), root.GetTypeName()) == expected
    assert "I-USD-KEYFRAME" in losses(robot)
    # As the parser of UsdPhysics, which Newton uses, has it.
    (articulation,) = parsed(usd.stage, "Articulation")
    assert [str(body.name) for body in articulation.articulatedBodies if body] == sorted(usd.bodies)
    assert {row.name for row in articulation.articulatedJoints} == set(usd.joints)


def test_bodies_of_a_plate_and_of_nothing_have_valid_masses(tmp_path):
    plate = Inertial(0.3, frozen(np.zeros(3)), frozen(np.diag([0.1, 0.2, 0.3]) / 3))
    nothing = Inertial(0.0, frozen(np.zeros(3)), frozen(np.zeros((3, 3))))
    rows = [joint("revolute", "base", "plate"), joint("fixed", "plate", "tip")]
    robot = robot_with(rows, inertials={"plate": plate}, given={"tip": nothing})
    usd = read(tmp_path, robot)
    moments = pxr.UsdPhysics.MassAPI(usd.bodies["plate"]).GetDiagonalInertiaAttr().Get()
    assert np.float32(moments[0]) + np.float32(moments[1]) >= np.float32(moments[2])
    assert usd.mass("tip")[0] == pytest.approx(1e-12)


def test_missing_package_is_told_before_anything_is_built(monkeypatch):
    plan = plan_of(export={"usd": {}})
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "pxr" else find(name))
    (problem,) = plan_problems(plan)
    assert "usd-core, which is not installed" in problem.message
    assert problem.where == "export.usd"
    assert "pip install 'usd-core>=" in problem.hint
    assert plan_problems(plan_of()) == []


def test_commands_of_the_page_run(tmp_path, monkeypatch, capsys):
    page = (PROJECT / "pipeline/reference/formats/USD.md").read_text()
    (code,) = re.findall(r"<!-- test -->\n```py\n(.*?)```", page, re.DOTALL)
    limits = {"elbow": Limits(-1, 2)}
    robot = robot_with([joint("revolute", "base", "arm", name="elbow", limits=limits)], name="my_arm")
    stage_of(usd_export(robot).files, tmp_path / "outputs" / "my_arm", "my_arm")
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "USD.md", "exec"), {})
    name, *ends = capsys.readouterr().out.split()
    assert (name, [math.radians(float(end)) for end in ends]) == ("elbow", pytest.approx([-1, 2]))


def test_names_that_are_no_identifiers_are_told_and_shown(tmp_path):
    rows = [
        joint("revolute", "base", "joints", name="2nd.axis"),
        joint("fixed", "joints", "wrist-link", name="wrist"),
        joint("cylindrical", "joints", "wrist_link", name="rœd"),
    ]
    robot = robot_with(rows, frames=[Frame("visuals", "base", frozen(np.eye(4)), "")])
    usd = read(tmp_path, robot)
    assert set(usd.bodies) == {"base", "joints", "wrist_link", "wrist_link_2", "roed_1"}
    assert set(usd.joints) == {"root_joint", "_2nd_axis", "wrist", "roed_slide", "roed_turn"}
    assert usd.bodies["wrist_link_2"].GetDisplayName() == "wrist-link"
    assert usd.joints["_2nd_axis"].GetPrim().GetDisplayName() == "2nd.axis"
    said = losses(robot)["I-USD-NAME"]
    assert "link 'wrist-link' is 'wrist_link_2'" in said
    assert "joint '2nd.axis' is '_2nd_axis'" in said
