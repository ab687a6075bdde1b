"""Loops and relations of the MJCF in simulations: they move and hold as the joints that they are."""

import math

import mujoco
import numpy as np
import pytest

from linkwright.stages.robot.model.poses import inverse, quat_from_rotation, rotation_from_rpy
from linkwright.stages.robot.model.robot import Inertial, Relation, frozen
from linkwright.stages.robot.motion.kinematics import chain, link_poses, saved_configuration
from linkwright.stages.robot.motion.loops import gap
from linkwright.stages.robot.motion.start_pose import starting_point
from tests.support import robots
from tests.support.building import robot_of
from tests.support.kit import four_bar
from tests.support.robots import at, joint, loop, robot_with, solid, some_value
from tests.support.states import equality_errors, pose_of, run, state
from tests.unit.export.test_mjcf import NUMBERS, model_of


def hung(kind, rng):
    """Two bodies, the first on a ball joint, the second joined to it by a mate of this type: as a tree,
    and as a loop that ties down a body that is free otherwise."""
    place = robots.pose(rng, 0.1)
    values = [some_value(freedom, rng, 0.3) for _, freedom, _ in robots.CHAINS[kind]]
    inertials = {"a": solid(2.0, (0.05, 0.02, 0.1)), "b": solid(1.0, (0.03, 0.1, 0.05))}
    top = joint("ball", "base", "a", place=at(0, 0, 1))
    tree = robot_with([top, joint(kind, "a", "b", values, place=place)], inertials=inertials)
    pose = link_poses(tree, saved_configuration(tree))["b"]
    there = tuple(map(float, (*pose[:3, 3], *quat_from_rotation(pose[:3, :3]))))
    mate = loop(kind, "b", "a", np.eye(4), place, values)
    return tree, robot_with([top, joint("free", "base", "b", [there])], loops=[mate], inertials=inertials)


def fallen(robot, seconds, step):
    model = model_of(robot, scene__option={"timestep": step})
    data = run(model, state(model, "cad"), seconds)
    mujoco.mj_kinematics(model, data)
    return {name: pose_of(data.body(name)) for name in ("a", "b")}


@pytest.mark.parametrize("kind", robots.LOOPS)
def test_loop_moves_as_the_joint_that_it_is(kind):
    """MuJoCo's own joint is the oracle. What is left is of the order of the time step."""
    tree, loop_of_it = hung(kind, np.random.default_rng(3))
    expected, actual = fallen(tree, 0.15, 3e-4), fallen(loop_of_it, 0.15, 3e-4)
    start = link_poses(tree, saved_configuration(tree))
    for name in ("a", "b"):
        assert np.abs(expected[name] - start[name]).max() > 0.05
        assert np.abs(actual[name] - expected[name]).max() < 1e-3, name
    masses = [model_of(robot).body_mass.sum() for robot in (tree, loop_of_it)]
    assert masses[0] == pytest.approx(masses[1], rel=1e-12)


@pytest.mark.parametrize(("factor", "rotor"), [(0.003, 1e-3), (-0.01, 1e-3), (1.0, 0.1), (-40.0, 1e3)])
def test_relation_holds_under_load(factor, rotor):
    """A screw, and steeper ones: (I + k² m) θ̈ = τ + k F, the way being ½ θ̈ t (t + h)."""
    thread = Relation("thread", "arm_joint_slide", "arm_joint_turn", factor, 0.0)
    inertials = {"arm": Inertial(2.0, frozen(np.zeros(3)), frozen(rotor * np.diag([1.5, 1.5, 1.0])))}
    robot = robot_with([joint("cylindrical", "base", "arm")], relations=[thread], inertials=inertials)
    model = model_of(robot)
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


@pytest.mark.parametrize("factor", [0.25, 4.0])
def test_relation_counts_from_qpos0(factor):
    relation = Relation("gears", "two_joint", "one_joint", factor, 0.3)
    joints = [joint("revolute", "base", "one", (0.4,)), joint("revolute", "base", "two", (0.7,))]
    model = model_of(robot_with(joints, relations=[relation]))
    for driver in (0.0, 0.4, -1.3):
        data = state(model, one_joint=driver, two_joint=factor * driver + 0.3)
        assert np.abs(data.efc_pos).max() < NUMBERS


def test_loop_of_hinges_gives_way_to_no_load():
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
    model = model_of(robot)
    data = mujoco.MjData(model)
    data.xfrc_applied[model.body("one").id][:3] = [-800.0, 0.0, 500.0]
    run(model, data, 1.0)
    assert np.abs(data.qvel).max() < 1e-6
    assert np.abs(data.qpos).max() < 1e-6  # by MuJoCo's default it is 1000 times more


def sliders():
    """Four slides in a loop: a on the ground, b on a, c on the ground, b along c; skew in space."""

    def along(*way):
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


def test_loop_of_slides_holds_under_load():
    """All is translation, so mass and conditions are constant, and the motion is ½ q̈ t² in closed form;
    MuJoCo's semi-implicit step makes that ½ q̈ t (t + h)."""
    robot = sliders()
    model, mate = model_of(robot), robot.loops[0]
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


def test_carrier_is_on_the_fixed_link():
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
    model = model_of(robot)
    names = [model.body(index).name for index in range(model.nbody)]
    assert names == ["world", "b", "loop_carrier", "more_carrier"]
    assert np.allclose(model.body_mass[1:], robot.link("b").inertial.mass / 3)
    errors = equality_errors(model, state(model))
    assert len(errors) == 12
    assert np.abs(errors).max() < NUMBERS
    for name, value in zip(("loop_x", "loop_y", "loop_turn"), values, strict=True):
        assert model.joint(name).qpos0[0] == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize("kind", robots.LOOPS)
def test_gap_is_what_the_loops_own_dofs_cannot_explain(kind):
    """At zero the tree has moved by the loop's own motion: closed. Tilted besides: open by the tilt."""
    rng = np.random.default_rng(8)
    values = [some_value(freedom, rng, 0.4) for _, freedom, _ in robots.CHAINS[kind]]
    names = [kind_of.name for kind_of in robots.dofs_of("loop", kind)]
    motion_of_loop = chain(robots.dofs_of("loop", kind, values), dict(zip(names, values, strict=True)))
    place = robots.pose(rng)
    mate = loop(kind, "a", "base", np.eye(4), place, values)
    closed = robot_with([joint("fixed", "base", "a", place=place @ motion_of_loop)], loops=[mate])
    assert gap(mate, link_poses(closed)) < 1e-12
    start = starting_point(closed)
    for name, value in zip(names, values, strict=True):
        assert np.allclose(start[name], value, atol=1e-12) or np.allclose(start[name], -np.array(value))
    tilt = robots.from_parts(rotation_from_rpy((0.01, 0.0, 0.0)), np.zeros(3))
    shift = at(0.0, 0.0, 0.003)
    open_by = {}
    for name, off in (("tilt", tilt), ("shift", shift)):
        moved = robot_with([joint("fixed", "base", "a", place=place @ motion_of_loop @ off)])
        open_by[name] = gap(mate, link_poses(moved))
    assert open_by["tilt"] == pytest.approx(0.0 if kind == "ball" else 0.01, abs=1e-6)
    slides_along_z = kind in ("prismatic", "cylindrical", "parallel")
    assert open_by["shift"] == pytest.approx(0.0 if slides_along_z else 0.003, abs=1e-12)


def test_qpos0_is_mate_zero_where_loops_close_there(kit):
    four_bar(kit)
    robot = robot_of(kit.document)
    assert {starting_point(robot)[dof.name] for dof in robot.dofs} == {0.0}
    model = model_of(robot)
    errors = equality_errors(model, state(model))
    assert len(errors) > 0
    assert np.abs(errors).max() < 1e-9
