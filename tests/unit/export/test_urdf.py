"""URDF of every kind of joint and shape, as Pinocchio and MuJoCo read it."""

import math

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkwright.stages.export.losses import losses as of_format
from linkwright.stages.export.urdf.lowering import lower
from linkwright.stages.export.urdf.model import write_urdf
from linkwright.stages.export.writer import Case
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import parse
from linkwright.stages.mesh.collide.primitives import shapes as primitive_shapes
from linkwright.stages.robot.dynamics.inertia import primitive_volume
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Primitive, Relation, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate.dynamics.mujoco_features import reads_mimic
from tests.support.pinocchio import pin
from tests.support.robots import EVERY, LOOPS, at, joint, loop, pose, robot_around, robot_with, some_values

NO_SHAPES = Geometry((), {})
SEVERAL = {
    "cylindrical": ("slide", "turn"), "planar": ("x", "y", "turn"), "pin_slot": ("slide", "turn"),
    "parallel": ("x", "y", "z", "turn"), "ball": ("x", "y", "z"),
}  # fmt: skip


def urdf(robot, geometry=NO_SHAPES):
    return write_urdf(Written(robot, geometry=geometry))


def losses(robot):
    written = Written(robot)
    diagnostics = of_format(Case("urdf", written, written.as_urdf.robot, "robot.urdf", None))
    return {diagnostic.code: diagnostic.message for diagnostic in diagnostics}


def scalars(robot, q):
    """Values of the URDF's joints of one degree of freedom; a ball as x, y and z turns by scipy."""
    out = {}
    for dof in robot.dofs:
        value = q[dof.name]
        if dof.kind == "ball":
            w, *xyz = value
            angles = Rotation.from_quat([*xyz, w]).as_euler("XYZ")
            out |= {f"{dof.name}_{letter}": angle for letter, angle in zip("xyz", angles, strict=True)}
        elif dof.kind != "free":
            out[dof.name] = value
    return out


def floats(robot, q):
    return {dof.name: q[dof.name] for dof in robot.dofs if dof.kind == "free"}


def by_pinocchio(text, robot, q):
    model = pin.buildModelFromXML(text.decode())
    data = model.createData()
    values = pin.neutral(model)
    for name, value in scalars(robot, q).items():
        turned = model.joints[model.getJointId(name)]
        assert turned.nv == 1
        coordinates = [value] if turned.nq == 1 else [math.cos(value), math.sin(value)]
        values[turned.idx_q : turned.idx_q + turned.nq] = coordinates
    for name, (x, y, z, qw, qx, qy, qz) in floats(robot, q).items():
        start = model.joints[model.getJointId(name)].idx_q
        values[start : start + 7] = [x, y, z, qx, qy, qz, qw]
    pin.framesForwardKinematics(model, data, values)
    bodies = [(i, f.name) for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY]
    return {name: data.oMf[index].homogeneous for index, name in bodies}


def by_mujoco(text, robot, q):
    model = mujoco.MjModel.from_xml_string(text.decode())
    data = mujoco.MjData(model)
    for name, value in scalars(robot, q).items():
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_kinematics(model, data)
    out = {}
    for index in range(1, model.nbody):
        out[model.body(index).name] = np.eye(4)
        out[model.body(index).name][:3, :3] = data.xmat[index].reshape(3, 3)
        out[model.body(index).name][:3, 3] = data.xpos[index]
    return out


@pytest.mark.parametrize("root", ["base", "world"])
@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kind", EVERY)
def test_links_are_where_the_robots_own_kinematics_have_them(kind, backwards, root):
    rng = np.random.default_rng(EVERY.index(kind))
    robot = robot_around(kind, rng, root, backwards)
    text = urdf(robot)
    engines = [by_pinocchio] if kind == "free" else [by_pinocchio, by_mujoco]
    for _ in range(5):
        q = some_values(robot, rng)
        expected = link_poses(robot, q)
        for engine in engines:
            poses = engine(text, robot, q)
            apart = {name: np.abs(poses[name] - expected[name]).max() for name in expected if name != "world"}
            assert max(apart.values()) < 1e-12 * 8, (engine, apart)


@pytest.mark.parametrize("fixed", [True, False])
def test_mass_is_the_robots_and_links_between_weigh_nothing(fixed):
    rng = np.random.default_rng(3)
    rows = [joint(kind, "base", f"{kind}_link", place=pose(rng)) for kind in LOOPS]
    robot = robot_with(rows, fixed=fixed)
    made_up = [name for item in lower(robot) for name in item.between]
    assert len(made_up) == sum(len(names) - 1 for names in SEVERAL.values())
    total = sum(link.inertial.mass for link in robot.links)
    text = urdf(robot)
    model = mujoco.MjModel.from_xml_string(text.decode())
    assert model.body_mass.sum() == pytest.approx(total, abs=1e-10)
    for name in made_up:
        body = model.body(name)
        assert (body.mass[0], *body.inertia) == (1e-12,) * 4
    there = pin.buildModelFromXML(text.decode(), pin.JointModelFreeFlyer())
    assert pin.computeTotalMass(there) == pytest.approx(total, abs=1e-10)


def test_a_ball_moves_as_one_whatever_its_three_turns_are():
    # Kinetic energy of a spinning ball joint, by its angular velocity and by Pinocchio's Euler rates.
    rng = np.random.default_rng(4)
    robot = robot_with([joint("ball", "base", "arm", place=pose(rng))])
    model = pin.buildModelFromXML(urdf(robot).decode())
    data = model.createData()
    angles, rates = np.array([0.3, -0.8, 1.1]), np.array([0.5, -0.2, 0.9])
    q = np.ravel([[math.cos(a), math.sin(a)] for a in angles])
    energy = pin.computeKineticEnergy(model, data, q, rates)
    step = 1e-6

    def turned(t):
        return Rotation.from_euler("XYZ", angles + t * rates).as_matrix()

    spin = turned(0).T @ (turned(step) - turned(-step)) / (2 * step)
    omega = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
    body = robot.link("arm").inertial
    across = np.cross(omega, body.com)
    expected = (omega @ body.inertia @ omega + body.mass * across @ across) / 2
    assert energy == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize(("kind", "suffixes"), SEVERAL.items())
def test_lowered_joints_are_reported_in_the_order_of_the_chain(kind, suffixes):
    message = losses(robot_with([joint(kind, "base", "arm")]))["I-URDF-LOWERED"]
    names = ", ".join(f"arm_joint_{suffix}" for suffix in suffixes)
    assert f"arm_joint ({kind}: {names})" in message
    if kind != "ball":
        (item,) = lower(robot_with([joint(kind, "base", "arm", backwards=True)]))
        assert [part.name for part in item.joints] == [f"arm_joint_{suffix}" for suffix in suffixes[::-1]]
        assert [part.child for part in item.joints] == [*item.between, "arm"]


def test_names_that_are_made_up_take_no_other_ones():
    rows = [
        joint("ball", "base", "hip", name="hip"), joint("revolute", "base", "hip_1", name="hip_x"),
        joint("cylindrical", "base", "rod", name="rod"), joint("planar", "base", "puck", name="hip_1"),
    ]  # fmt: skip
    robot = robot_with(rows, frames=[Frame("hip_2", "base", frozen(np.eye(4)), "Hip")])
    ball, _, rod, puck = lower(robot)
    assert [part.name for part in ball.joints] == ["hip_x_2", "hip_y", "hip_z"]
    assert ball.between == ("hip_1_2", "hip_2_2")
    assert rod.between == ("rod_1",)
    assert puck.between == ("hip_1_1", "hip_1_2_2")
    root = parse(urdf(robot))
    for tag in ("link", "joint"):
        names = [node.get("name") for node in root.findall(tag)]
        assert len(set(names)) == len(names)
    assert "hip_2" in {node.get("name") for node in root.findall("link")}


def test_limits_and_dynamics_are_each_dofs_own():
    limits = {"arm_joint_x": Limits(-0.1, 0.2), "arm_joint_turn": Limits(None, 1.0)}
    dynamics = Dynamics(damping=0.5, effort=7, velocity=3)
    robot = robot_with([joint("planar", "base", "arm", limits=limits, dynamics=dynamics)])
    nodes = {node.get("name"): node for node in parse(urdf(robot)).findall("joint")}
    ends = {name: (n.find("limit").get("lower"), n.find("limit").get("upper")) for name, n in nodes.items()}
    assert ends["arm_joint_x"] == ("-0.1", "0.2")
    assert ends["arm_joint_y"] == ("-1", "1")
    assert float(ends["arm_joint_turn"][0]) == pytest.approx(-2 * math.pi)
    assert {node.find("limit").get("effort") for node in nodes.values()} == {"7"}
    assert {node.find("dynamics").get("damping") for node in nodes.values()} == {"0.5"}
    message = losses(robot)["I-URDF-UNSET"]
    assert message.endswith("arm_joint_y: lower, upper; arm_joint_turn: lower")


def test_what_urdf_cannot_express_is_reported():
    cone = joint("ball", "base", "arm", limits={"arm_joint": Limits(None, 0.5)})
    lost = losses(robot_with([cone, joint("ball", "arm", "hand"), joint("free", "base", "nut")]))
    assert list(lost) == ["I-URDF-LOWERED", "W-BALL-CONE", "I-URDF-FREE", "I-URDF-UNSET"]
    assert lost["W-BALL-CONE"].endswith(": arm_joint")
    assert lost["I-URDF-FREE"].endswith(": nut_joint")
    assert lost["I-URDF-UNSET"].endswith("arm_joint: effort, velocity; hand_joint: effort, velocity")
    assert losses(robot_with([joint("fixed", "base", "arm")])) == {}


def test_a_relation_of_two_dofs_of_one_joint_is_a_mimic():
    relation = Relation("Screw", "nut_joint_slide", "nut_joint_turn", 0.002, 0.1)
    robot = robot_with([joint("cylindrical", "base", "nut")], relations=[relation])
    nodes = {node.get("name"): node for node in parse(urdf(robot)).findall("joint")}
    mimic = nodes["nut_joint_slide"].find("mimic")
    assert dict(mimic.attrib) == {"joint": "nut_joint_turn", "multiplier": "0.002", "offset": "0.1"}
    assert nodes["nut_joint_turn"].find("mimic") is None
    if reads_mimic():
        model = mujoco.MjModel.from_xml_string(urdf(robot).decode())
        assert np.allclose(model.eq_data[0][:2], [0.1, 0.002])


@pytest.mark.parametrize("kind", LOOPS)
def test_a_loop_of_any_type_is_a_frame_on_either_side(kind):
    rng = np.random.default_rng(6)
    near, far = pose(rng), pose(rng)
    rows = [
        joint("planar", "base", "one", place=pose(rng)),
        joint("revolute", "base", "two", place=pose(rng)),
    ]
    robot = robot_with(rows, loops=[loop(kind, "one", "two", near, far, name="shut")])
    q = some_values(robot, rng)
    poses, links = by_pinocchio(urdf(robot), robot, q), link_poses(robot, q)
    assert np.abs(poses["shut_a"] - links["one"] @ near).max() < 1e-11
    assert np.abs(poses["shut_b"] - links["two"] @ far).max() < 1e-11
    assert "shut" in losses(robot)["I-URDF-LOOP"]


def test_root_called_world_is_mujocos_world():
    text = urdf(robot_with([joint("revolute", "world", "arm", place=at(1, 2, 3))], root="world"))
    assert len(parse(text).find("link[@name='world']")) == 0
    model = mujoco.MjModel.from_xml_string(text.decode())
    assert [model.body(index).name for index in range(model.nbody)] == ["world", "arm"]


def test_free_body_of_the_world_is_where_it_rests():
    rng = np.random.default_rng(11)
    rows = [joint("free", "world", "nut", place=pose(rng)), joint("revolute", "nut", "arm", place=pose(rng))]
    robot = robot_with(rows, root="world")
    expected, actual = link_poses(robot), by_mujoco(urdf(robot), robot, {"arm_joint": 0.0, "nut_joint": ()})
    assert max(np.abs(actual[name] - expected[name]).max() for name in ("nut", "arm")) < 1e-11


PLACE = pose(np.random.default_rng(8))
RED = (1.0, 0.0, 0.0, 1.0)
PRIMITIVES = {"box": (0.1, 0.2, 0.3), "sphere": (0.1,), "cylinder": (0.1, 0.4), "capsule": (0.1, 0.4)}


@pytest.mark.parametrize(("kind", "size"), PRIMITIVES.items())
def test_a_primitive_is_seen_and_collides_where_it_is(kind, size):
    shape = Primitive(kind, size, frozen(PLACE), RED)
    robot = robot_with([joint("revolute", "base", "arm")], shapes={"arm": (shape,)})
    geometry = Geometry(tuple(primitive_shapes(robot.link("arm"))), {})
    text = urdf(robot, geometry)
    link = parse(text).find("link[@name='arm']")
    tags = {"capsule": ["cylinder", "sphere", "sphere"]}.get(kind, [kind])
    for role in ("visual", "collision"):
        assert [node[0].tag for node in link.findall(f"{role}/geometry")] == tags
    assert {node.get("name") for node in link.findall("visual/material")} == {"red"}
    assert not link.findall("collision/material")
    model = mujoco.MjModel.from_xml_string(text.decode())
    assert model.ngeom == 2 * len(tags)
    assert np.allclose(model.geom_rgba[model.geom_group == 1], RED)
    assert_fills(model, shape)
    # Geometry adds no mass.
    assert model.body("arm").mass[0] == pytest.approx(robot.link("arm").inertial.mass)
    visual = pin.buildGeomFromUrdfString(pin.buildModelFromXML(text.decode()), text.decode(), pin.VISUAL)
    assert visual.ngeoms == len(tags)


def assert_fills(model, shape):
    """MuJoCo's rays from outside meet the surface where the primitive has it."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    link = data.body("arm").xmat.reshape(3, 3)
    centre, turn = data.body("arm").xpos + link @ PLACE[:3, 3], link @ PLACE[:3, :3]
    for direction in np.random.default_rng(1).normal(size=(40, 3)):
        direction /= np.linalg.norm(direction)
        start = centre + turn @ direction * 2
        met = mujoco.mj_ray(model, data, start, -turn @ direction, None, 1, -1, np.zeros(1, dtype=np.int32))
        assert 2 - met == pytest.approx(radius_along(shape, direction), abs=1e-9)


def radius_along(shape, direction):
    """How far the surface is from the middle of the shape in a direction, in closed form."""
    if shape.kind == "box":
        return float(np.min(np.array(shape.size) / 2 / np.abs(direction)))
    radius, half = shape.size[0], (shape.size[1] / 2 if len(shape.size) > 1 else 0.0)
    across, along = math.hypot(*direction[:2]), abs(direction[2])
    side = radius / across
    if shape.kind == "cylinder":
        return min(side, half / along)
    if side * along <= half and shape.kind == "capsule":
        return side
    # On the ball about (0, 0, half): |t d − h| = r.
    return along * half + math.sqrt(radius**2 - half**2 * across**2)


def test_a_primitive_that_is_only_seen_does_not_collide():
    ghost = Primitive("box", (1.0, 1.0, 1.0), frozen(np.eye(4)), None, visual=True, collision=False)
    robot = robot_with([], shapes={"base": (ghost,)})
    text = urdf(robot, Geometry(tuple(primitive_shapes(robot.root)), {}))
    link = parse(text).find("link")
    assert [node.tag for node in link] == ["inertial", "visual"]
    assert primitive_volume(ghost.kind, ghost.size) == 1
