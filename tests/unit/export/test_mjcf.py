"""The MJCF, read back by MuJoCo: joints, loops and shapes of every type."""

import math
from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.stages.export.ground.standing import stand
from linkwright.stages.export.losses import losses
from linkwright.stages.export.mjcf.contact.filters import filters
from linkwright.stages.export.settled import settled
from linkwright.stages.export.writer import Case, WriterInput
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.poses import (
    inverse,
    motion,
    quat_from_rotation,
    rotation_from_quat,
    rotation_from_rpy,
)
from linkwright.stages.robot.model.robot import (
    Array,
    Dynamics,
    Frame,
    Inertial,
    Joint,
    Limits,
    Primitive,
    Relation,
    Robot,
    Value,
    frozen,
)
from linkwright.stages.robot.motion.kinematics import chain, link_poses, saved_configuration
from linkwright.stages.robot.motion.loops import gap
from linkwright.stages.robot.motion.start_pose import starting_point
from tests.support import robots
from tests.support.building import NO_MESHES, plan_of, robot_of, write
from tests.support.kit import SIDE, TOP, Kit, four_bar
from tests.support.robots import EVERY, at, joint, loop, robot_with, solid, some_value, some_values

NUMBERS = 1e-10
"""What the formatter's 1e-12 of every number adds up to along a chain of nine joints."""


def compiled(robot: Robot, geometry: Geometry = NO_MESHES, **keys: object) -> mujoco.MjModel:
    plan = settled(plan_of(**keys), robot)
    given = WriterInput(Written(robot, geometry=geometry), plan, stand(robot, geometry, plan))
    files = WRITERS["mjcf"].write(given).files
    return mujoco.MjModel.from_xml_string(files[f"{robot.name}.xml"].decode())


def body_pose(data: mujoco.MjData, name: str) -> Array:
    pose = np.eye(4)
    pose[:3, :3] = data.body(name).xmat.reshape(3, 3)
    pose[:3, 3] = data.body(name).xpos
    return pose


def site_pose(data: mujoco.MjData, name: str) -> Array:
    pose = np.eye(4)
    pose[:3, :3] = data.site(name).xmat.reshape(3, 3)
    pose[:3, 3] = data.site(name).xpos
    return pose


def set_values(model: mujoco.MjModel, robot: Robot, q: Mapping[str, Value]) -> mujoco.MjData:
    """The tree's joints at `q`; the robot stands at the world's origin."""
    data = mujoco.MjData(model)
    start = starting_point(robot)
    for one in robot.joints:
        for dof in one.dofs:
            numbers: object = q[dof.name]
            pose = motion(dof.kind, dof.axis, q[dof.name])
            if dof.kind == "ball":
                zero = motion(dof.kind, dof.axis, start[dof.name])
                numbers = quat_from_rotation((inverse(zero) @ pose)[:3, :3])
            if dof.kind == "free":
                pose = one.parent_from_joint @ pose
                numbers = [*pose[:3, 3], *quat_from_rotation(pose[:3, :3])]
            first = model.joint(dof.name).qposadr[0]
            data.qpos[first : first + np.size(numbers)] = numbers
    mujoco.mj_kinematics(model, data)
    return data


def chain_of_all(rng: np.random.Generator, backwards: bool) -> list[Joint]:
    """One joint of each type in a row, at odd places, with odd origins between the dofs."""
    made, above = [], "base"
    for kind in EVERY:
        if kind == "free":
            continue
        count = len(robots.CHAINS[kind])
        values = [some_value(what, rng) for _, what, _ in robots.CHAINS[kind]]
        origins = [robots.pose(rng) for _ in range(max(0, count - 1))]
        made.append(
            joint(kind, above, kind, values, place=robots.pose(rng), backwards=backwards, origins=origins)
        )
        above = kind
    values = [some_value("free", rng)]
    made.append(joint("free", "base", "loose", values, place=robots.pose(rng)))
    made.append(joint("revolute", "loose", "flap", [0.4], place=robots.pose(rng)))
    return made


def tied(robot: Robot) -> Relation:
    """A relation that holds at the saved pose alone, and so moves qpos0 there."""
    follower, driver = [dof for dof in robot.dofs if dof.kind in ("turn", "slide")][:2]
    return Relation("tie", follower.name, driver.name, 0.3, follower.saved - 0.3 * driver.saved)


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("from_saved", [False, True])
def test_every_joint_moves_as_the_robots_own_kinematics(backwards: bool, from_saved: bool) -> None:
    rng = np.random.default_rng(7)
    joints = chain_of_all(rng, backwards)
    relations = [tied(robot_with(joints))] if from_saved else []
    robot = robot_with(
        joints, relations=relations, frames=[Frame("tip", "parallel", robots.pose(rng), "Tip")]
    )
    start = starting_point(robot)
    assert (start == saved_configuration(robot)) == from_saved
    model = compiled(robot)
    for _ in range(5):
        q = some_values(robot, rng)
        data = set_values(model, robot, q)
        expected = link_poses(robot, q)
        for name, pose in expected.items():
            assert np.abs(body_pose(data, name) - pose).max() < NUMBERS, name
        tip = expected["parallel"] @ robot.frames[0].link_from_frame
        assert np.abs(site_pose(data, "tip") - tip).max() < NUMBERS


def test_a_root_called_world_is_the_worldbody_where_the_scene_puts_it() -> None:
    rng = np.random.default_rng(5)
    tip = Frame("tip", "world", robots.pose(rng), "Tip")
    joints = [joint("ball", "world", "arm", [(0.6, 0.0, 0.8, 0.0)], place=robots.pose(rng))]
    joints.append(joint("free", "world", "loose", [some_value("free", rng)], place=robots.pose(rng)))
    robot = robot_with(joints, root="world", frames=[tip])
    scene = robots.from_parts(rotation_from_rpy((0.1, 0.2, 0.3)), np.array([1.0, 2.0, 3.0]))
    model = compiled(robot, scene__pose={"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]})
    assert [model.body(index).name for index in range(model.nbody)] == ["world", "arm", "loose"]
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("cad").id)
    mujoco.mj_kinematics(model, data)
    for name, pose in link_poses(robot, saved_configuration(robot)).items():
        if name != "world":
            assert np.abs(body_pose(data, name) - scene @ pose).max() < NUMBERS
    assert np.abs(site_pose(data, "tip") - scene @ tip.link_from_frame).max() < NUMBERS
    assert np.abs(site_pose(data, "world") - scene).max() < NUMBERS


def test_keyframes_are_in_mujocos_order_whatever_the_order_of_the_links() -> None:
    """Links breadth first; MuJoCo numbers them depth first."""
    rng = np.random.default_rng(2)
    joints = [
        joint("cylindrical", "base", "one", (0.1, 0.2)),
        joint("ball", "base", "two", [some_value("ball", rng)]),
        joint("planar", "one", "three", (0.3, 0.4, 0.5), backwards=True),
        joint("revolute", "two", "four", (0.6,)),
    ]
    limits = {"four_joint": Limits(-0.5, 0.5)}
    joints[3] = joint("revolute", "two", "four", (0.6,), limits=limits)
    robot = robot_with(joints, fixed=False)
    model = compiled(robot)
    data = mujoco.MjData(model)
    for key, last in (("cad", 0.6), ("home", 0.5)):
        mujoco.mj_resetDataKeyframe(model, data, model.key(key).id)
        mujoco.mj_kinematics(model, data)
        q = dict(saved_configuration(robot), four_joint=last)
        for name, pose in link_poses(robot, q).items():
            assert np.abs(body_pose(data, name) - pose).max() < NUMBERS


def test_limits_and_dynamics_belong_to_each_dof_and_a_cone_is_reported() -> None:
    limits = {"arm_joint_slide": Limits(-0.1, 0.2), "tip_joint": Limits(upper=0.5)}
    dynamics = Dynamics(damping=0.1, friction=0.2, armature=0.3, effort=4.0)
    joints = [
        joint("cylindrical", "base", "arm", limits=limits, dynamics=dynamics),
        joint("ball", "arm", "tip", limits=limits, dynamics=dynamics),
    ]
    robot = robot_with(joints)
    model = compiled(robot)
    assert list(model.joint("arm_joint_slide").range) == [-0.1, 0.2]
    assert not model.jnt_limited[model.joint("arm_joint_turn").id]
    assert not model.jnt_limited[model.joint("tip_joint").id]
    assert list(model.dof_damping) == [0.1] * 5
    written = Written(robot)
    apart = filters(written.as_mjcf.robot, written.mjcf_shapes)
    found = list(losses(Case("mjcf", written, robot, "robot.xml", apart)))
    assert [(one.code, one.where) for one in found] == [
        ("W-BALL-CONE", "robot.xml"),
        ("W-BALL-EFFORT", "robot.xml"),
        ("I-BALL-ZERO", "robot.xml"),
    ]
    assert all("tip_joint" in one.message for one in found)


@pytest.mark.parametrize("size", [1.0, 1e-7, 1e-10])
def test_inertias_are_written_about_principal_axes(size: float) -> None:
    """Every MuJoCo takes these as they are; of whole tensors those up to 3.13 lose the sixth digit, and
    of small ones more."""
    turned = rotation_from_quat(np.array([0.2, 0.3, -0.7, 0.4]))
    tensor = size * turned @ np.diag([1.0, 0.8, 0.5]) @ turned.T
    robot = robot_with(
        [joint("revolute", "base", "arm")],
        inertials={"arm": Inertial(size, frozen(np.zeros(3)), frozen(tensor))},
    )
    model = compiled(robot)
    arm = model.body("arm")
    axes = rotation_from_quat(model.body_iquat[arm.id])
    found = axes @ np.diag(arm.inertia) @ axes.T
    assert np.abs(found - tensor).max() < 1e-11 * size


@pytest.mark.parametrize("angle", [1e-9, 1.1e-8, 3e-7, 2e-6, 1e-4])
def test_an_inertia_that_is_turned_by_next_to_nothing_stays_turned(angle: float) -> None:
    """MuJoCo moves an inertial that is turned by less than 1e-6 rad with the body's own axes."""
    turned = rotation_from_rpy((0.0, angle, 0.0))
    tensor = frozen(turned @ np.diag([1.0, 0.8, 0.5]) @ turned.T)
    row = joint("ball", "base", "arm")
    model = compiled(robot_with([row], inertials={"arm": Inertial(1.0, frozen(np.zeros(3)), tensor)}))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    arm = model.body("arm").id
    body, axes = data.xmat[arm].reshape(3, 3), data.ximat[arm].reshape(3, 3)
    found = body.T @ axes @ np.diag(model.body_inertia[arm]) @ axes.T @ body
    assert np.abs(found - tensor).max() < 2e-12


def test_primitives_have_mujocos_half_sizes() -> None:
    place = robots.pose(np.random.default_rng(4))
    sizes = {"box": (0.2, 0.4, 0.6), "sphere": (0.1,), "cylinder": (0.1, 0.4), "capsule": (0.1, 0.4)}
    red = (1.0, 0.0, 0.0, 1.0)
    shapes = []
    for kind, size in sizes.items():
        primitive = Primitive(kind, size, frozen(place), red)
        shapes.append(Shape("arm", "visual", None, red, 0, 0, 1.0, 1.0, primitive))
        shapes.append(Shape("arm", "collision", None, None, 0, 0, 1.0, 1.0, primitive))
    robot = robot_with([joint("revolute", "base", "arm")])
    model = compiled(robot, Geometry(tuple(shapes), {}))
    assert model.ngeom == 8
    for index, (kind, half) in enumerate(
        {"box": (0.1, 0.2, 0.3), "sphere": (0.1,), "cylinder": (0.1, 0.2), "capsule": (0.1, 0.2)}.items()
    ):
        geom = model.geom(f"arm_collision_{index}")
        assert geom.type == getattr(mujoco.mjtGeom, f"mjGEOM_{kind.upper()}")
        assert np.allclose(geom.size[: len(half)], half)
        assert np.allclose(geom.pos, place[:3, 3])
    assert model.body_mass.sum() == pytest.approx(sum(link.inertial.mass for link in robot.links))


def hung(kind: str, rng: np.random.Generator) -> tuple[Robot, Robot]:
    """Two bodies, the first on a ball joint, the second joined to it by a mate of this type: as a tree,
    and as a loop that ties down a body that is free otherwise."""
    place = robots.pose(rng, 0.1)
    values = [some_value(what, rng, 0.3) for _, what, _ in robots.CHAINS[kind]]
    inertials = {"a": solid(2.0, (0.05, 0.02, 0.1)), "b": solid(1.0, (0.03, 0.1, 0.05))}
    top = joint("ball", "base", "a", place=at(0, 0, 1))
    tree = robot_with([top, joint(kind, "a", "b", values, place=place)], inertials=inertials)
    pose = link_poses(tree, saved_configuration(tree))["b"]
    there = tuple(map(float, (*pose[:3, 3], *quat_from_rotation(pose[:3, :3]))))
    mate = loop(kind, "b", "a", np.eye(4), place, values)
    return tree, robot_with([top, joint("free", "base", "b", [there])], loops=[mate], inertials=inertials)


def fallen(robot: Robot, seconds: float, step: float) -> dict[str, Array]:
    model = compiled(robot, scene__option={"timestep": step})
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("cad").id)
    for _ in range(round(seconds / step)):
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    return {name: body_pose(data, name) for name in ("a", "b")}


@pytest.mark.parametrize("kind", robots.LOOPS)
def test_a_loop_moves_as_the_joint_that_it_is(kind: str) -> None:
    """MuJoCo's own joint is the oracle. What is left is of the order of the time step."""
    tree, loop_of_it = hung(kind, np.random.default_rng(3))
    expected, found = fallen(tree, 0.15, 3e-4), fallen(loop_of_it, 0.15, 3e-4)
    start = link_poses(tree, saved_configuration(tree))
    for name in ("a", "b"):
        assert np.abs(expected[name] - start[name]).max() > 0.05
        assert np.abs(found[name] - expected[name]).max() < 1e-3, name
    masses = [compiled(robot).body_mass.sum() for robot in (tree, loop_of_it)]
    assert masses[0] == pytest.approx(masses[1], rel=1e-12)


@pytest.mark.parametrize(("factor", "rotor"), [(0.003, 1e-3), (-0.01, 1e-3), (1.0, 0.1), (-40.0, 1e3)])
def test_what_is_related_holds_together_under_load(factor: float, rotor: float) -> None:
    """A screw, and steeper ones: (I + k² m) θ̈ = τ + k F, the way being ½ θ̈ t (t + h)."""
    thread = Relation("thread", "arm_joint_slide", "arm_joint_turn", factor, 0.0)
    inertials = {"arm": Inertial(2.0, frozen(np.zeros(3)), frozen(rotor * np.diag([1.5, 1.5, 1.0])))}
    robot = robot_with([joint("cylindrical", "base", "arm")], relations=[thread], inertials=inertials)
    model = compiled(robot)
    model.opt.gravity[:] = 0
    data = mujoco.MjData(model)
    inertia = rotor + factor**2 * 2.0
    force, torque = -30.0, 30.0 * factor + 10 * inertia
    slide, turn = (data.joint(f"arm_joint_{name}") for name in ("slide", "turn"))
    slide.qfrc_applied[:], turn.qfrc_applied[:] = force, torque
    for _ in range(250):
        mujoco.mj_step(model, data)
        assert abs(slide.qpos[0] - factor * turn.qpos[0]) < 3e-6
    assert turn.qpos[0] == pytest.approx(5 * data.time * (data.time + model.opt.timestep), rel=1e-3)


def test_a_relation_counts_from_qpos0_whichever_joint_it_is_solved_for() -> None:
    for factor in (0.25, 4.0):
        relation = Relation("gears", "two_joint", "one_joint", factor, 0.3)
        joints = [joint("revolute", "base", "one", (0.4,)), joint("revolute", "base", "two", (0.7,))]
        robot = robot_with(joints, relations=[relation])
        model = compiled(robot)
        data = mujoco.MjData(model)
        for driver in (0.0, 0.4, -1.3):
            data.joint("one_joint").qpos[:] = driver
            data.joint("two_joint").qpos[:] = factor * driver + 0.3
            mujoco.mj_forward(model, data)
            assert np.abs(data.efc_pos).max() < NUMBERS


def test_a_loop_of_hinges_gives_way_to_no_load() -> None:
    """Two bars that lean on each other: a truss, which stands still whatever pulls at it."""
    y = robots.from_parts(rotation_from_rpy((-math.pi / 2, 0.0, 0.0)), np.zeros(3))
    tip = at(0.5, 0, 0)
    lean = robots.from_parts(rotation_from_rpy((0.0, 0.0, 1.0)), np.zeros(3))
    back = robots.from_parts(rotation_from_rpy((0.0, 0.0, math.pi - 1.0)), np.zeros(3))
    joints = [
        joint("revolute", "base", "one", place=y @ lean),
        joint("revolute", "base", "two", place=at(2 * 0.5 * math.cos(1.0), 0, 0) @ y @ back),
    ]
    inertials = {name: solid(1.0, (0.3, 0.0, 0.0)) for name in ("one", "two")}
    robot = robot_with(joints, loops=[loop("revolute", "one", "two", tip, tip)], inertials=inertials)
    model = compiled(robot)
    data = mujoco.MjData(model)
    data.xfrc_applied[model.body("one").id][:3] = [-800.0, 0.0, 500.0]
    for _ in range(500):
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel).max() < 1e-6
    assert np.abs(data.qpos).max() < 1e-6  # by MuJoCo's default it is 1000 times more


def sliders() -> Robot:
    """Four slides in a loop: a on the ground, b on a, c on the ground, b along c; skew in space."""

    def along(*way: float) -> Array:
        z = np.array(way) / np.linalg.norm(way)
        x = np.cross([0.0, 0.0, 1.0], z)
        x /= np.linalg.norm(x)
        return robots.from_parts(np.column_stack([x, np.cross(z, x), z]), np.zeros(3))

    first = along(1, 0, 0)
    joints = [
        joint("prismatic", "base", "a", place=first),
        joint("prismatic", "a", "b", place=inverse(first) @ at(0.3, 0, 0) @ along(0.3, 1, 0.2)),
        joint("prismatic", "base", "c", place=at(0, 0.1, 0) @ along(-0.2, 1, 0.2)),
    ]
    poses = link_poses(robot_with(joints))
    last = at(0.2, 0.15, 0.02) @ along(1, 0.1, 0)
    mate = loop("prismatic", "b", "c", inverse(poses["b"]) @ last, inverse(poses["c"]) @ last)
    return robot_with(joints, loops=[mate])


def test_a_loop_of_slides_holds_under_load() -> None:
    """All is translation, so mass and conditions are constant, and the motion is ½ q̈ t² in closed form;
    MuJoCo's semi-implicit step makes that ½ q̈ t (t + h)."""
    robot = sliders()
    model, mate = compiled(robot), robot.loops[0]
    names = ["a_joint", "b_joint", "c_joint", "loop"]
    load = np.array([1.0, 0.0, 2.0, 0.0])
    model.opt.gravity[:] = [1, 2, -9.81]
    data = mujoco.MjData(model)
    data.qfrc_applied[[model.joint(name).dofadr[0] for name in names]] = load
    drift = 0.0
    for _ in range(1000):
        mujoco.mj_step(model, data)
        values = {name: float(data.joint(name).qpos[0]) for name in names}
        drift = max(drift, gap(mate, link_poses(robot, values)))
    poses = link_poses(robot)
    way = {name: poses[name][:3, 2] for name in "abc"}
    none = np.zeros(3)
    moves = {
        "a": np.column_stack([way["a"], none, none, none]),
        "b": np.column_stack([way["a"], way["b"], none, none]),
        "c": np.column_stack([none, none, way["c"], none]),
    }
    masses = {name: robot.link(name).inertial.mass for name in "abc"}
    mass = sum(masses[name] * moves[name].T @ moves[name] for name in "abc")
    force = load + sum(masses[name] * moves[name].T @ model.opt.gravity for name in "abc")
    slide = (poses["c"] @ mate.b_from_frame)[:3, 2]
    closed = moves["b"] - moves["c"] - np.column_stack([none, none, none, slide])
    system = np.block([[mass, closed.T], [closed, np.zeros((3, 3))]])
    speed_up = np.linalg.lstsq(system, np.concatenate([force, none]), rcond=None)[0][:4]
    moved_by = 0.5 * speed_up * data.time * (data.time + model.opt.timestep)
    reach = np.abs(moved_by).max()
    assert reach > 0.4
    assert drift < 1e-5 * reach
    assert np.abs([data.joint(name).qpos[0] for name in names] - moved_by).max() < 1e-4 * reach


def test_a_carrier_is_on_the_fixed_link_and_shares_the_moving_one() -> None:
    """The mate's first entity is on the ground, which may have no mass: the chain runs the other way."""
    rng = np.random.default_rng(6)
    values = (0.1, 0.2, 0.7)
    place, near = robots.pose(rng), robots.pose(rng)
    second_from_first = chain(
        robots.dofs_of("loop", "planar", values),
        dict(zip(("loop_x", "loop_y", "loop_turn"), values, strict=True)),
    )
    root_from_b = place @ inverse(near @ second_from_first)
    there = tuple(map(float, (*root_from_b[:3, 3], *quat_from_rotation(root_from_b[:3, :3]))))
    mates = [loop("planar", "world", "b", place, near, values, name=name) for name in ("loop", "more")]
    robot = robot_with([joint("free", "world", "b", [there])], root="world", loops=mates)
    model = compiled(robot)
    assert [model.body(index).name for index in range(model.nbody)] == [
        "world",
        "b",
        "loop_carrier",
        "more_carrier",
    ]
    assert np.allclose(model.body_mass[1:], robot.link("b").inertial.mass / 3)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    equal = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    assert equal.sum() == 12
    assert np.abs(data.efc_pos[equal]).max() < NUMBERS
    for name, value in zip(("loop_x", "loop_y", "loop_turn"), values, strict=True):
        assert model.joint(name).qpos0[0] == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize("kind", robots.LOOPS)
def test_the_gap_is_what_the_loops_own_dofs_cannot_explain(kind: str) -> None:
    """At zero the tree has moved by the loop's own motion: closed. Tilted besides: open by the tilt."""
    rng = np.random.default_rng(8)
    values = [some_value(what, rng, 0.4) for _, what, _ in robots.CHAINS[kind]]
    names = [kind_of.name for kind_of in robots.dofs_of("loop", kind)]
    own = chain(robots.dofs_of("loop", kind, values), dict(zip(names, values, strict=True)))
    place = robots.pose(rng)
    mate = loop(kind, "a", "base", np.eye(4), place, values)
    closed = robot_with([joint("fixed", "base", "a", place=place @ own)], loops=[mate])
    assert gap(mate, link_poses(closed)) < 1e-12
    found = starting_point(closed)
    for name, value in zip(names, values, strict=True):
        assert np.allclose(found[name], value, atol=1e-12) or np.allclose(found[name], -np.array(value))
    tilt = robots.from_parts(rotation_from_rpy((0.01, 0.0, 0.0)), np.zeros(3))
    shift = at(0.0, 0.0, 0.003)
    open_by = {
        name: gap(mate, link_poses(robot_with([joint("fixed", "base", "a", place=place @ own @ off)])))
        for name, off in (("tilt", tilt), ("shift", shift))
    }
    assert open_by["tilt"] == pytest.approx(0.0 if kind == "ball" else 0.01, abs=1e-6)
    slides_along_z = kind in ("prismatic", "cylindrical", "parallel")
    assert open_by["shift"] == pytest.approx(0.0 if slides_along_z else 0.003, abs=1e-12)


def test_the_scene_reads_the_robot_with_all_of_it(tmp_path: Path) -> None:
    robot = robot_with(chain_of_all(np.random.default_rng(1), False))
    write(robot, tmp_path)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert model.nv == robot.mobility.coordinates
    assert model.geom("floor").type == mujoco.mjtGeom.mjGEOM_PLANE


def test_a_floating_base_has_a_free_joint_and_the_pose_that_the_scene_gives(kit: Kit, tmp_path: Path) -> None:
    arm, hand = kit.place("Arm"), kit.place("Hand")
    kit.root.revolute("Wrist", (hand, TOP), (arm, SIDE), limits=(-1, 1))
    plan = plan_of(scene={"pose": {"xyz": [1, 2, 3], "rpy": [0, 0, math.pi / 2]}}, root={"select": "arm"})
    write(robot_of(kit.document, plan), tmp_path, plan)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert (model.nq, model.nv) == (8, 7)
    assert model.joint("arm_free").type == mujoco.mjtJoint.mjJNT_FREE
    assert np.allclose(model.qpos0[:7], [1, 2, 3, math.sqrt(0.5), 0, 0, math.sqrt(0.5)], atol=1e-12)
    assert np.allclose(model.key("cad").qpos[:7], model.qpos0[:7])


def test_qpos0_is_mate_zero_where_loops_close_there(kit: Kit) -> None:
    four_bar(kit)
    robot = robot_of(kit.document)
    start = starting_point(robot)
    assert {start[dof.name] for dof in robot.dofs} == {0.0}
    model = compiled(robot)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    assert rows.any()
    assert np.abs(data.efc_pos[rows]).max() < 1e-9


def test_a_loop_stays_closed_while_it_is_simulated(kit: Kit, tmp_path: Path) -> None:
    four_bar(kit)
    write(robot_of(kit.document), tmp_path)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    model.opt.gravity[:] = [3, -5, 0]
    data = mujoco.MjData(model)
    worst = 0.0
    for _ in range(1000):
        mujoco.mj_step(model, data)
        rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        worst = max(worst, np.abs(data.efc_pos[rows]).max())
    assert worst < 1e-3
    assert np.abs(data.qpos).max() > 0.1


def test_the_ground_and_the_scene_are_as_asked(kit: Kit, tmp_path: Path) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3)
    plan = plan_of(ground={"size": [2, 3], "xyz": [0, 0, -0.5], "friction": [0.7, 0.01, 0.001]})
    write(robot_of(kit.document), tmp_path, plan)
    floor = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml")).geom("floor")
    assert list(floor.size[:2]) == [1, 1.5]
    assert list(floor.pos) == [0, 0, -0.5]
    assert list(floor.friction) == [0.7, 0.01, 0.001]
    bare = plan_of(ground={"kind": "none"}, scene={"option": {"timestep": 0.001}})
    write(robot_of(kit.document), tmp_path, bare)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert model.ngeom == 0
    assert model.opt.timestep == 0.001
