"""Random URDFs: what is read is what the file says, by Pinocchio on the file and MuJoCo on our MJCF.

Poses, mass matrix, gravity, limits and mimics agree at random values; with another link as the root the
poses do, and what the joints feel of the masses where nothing holds the robot.
"""

import math
import tempfile
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from linkwright.stages.robot.dynamics.inertia import moved
from tests.support.building import plan_of, write
from tests.support.checked import checked, failures
from tests.support.drawn import each
from tests.support.engines import Mujoco, Pinocchio
from tests.support.pinocchio import pin
from tests.support.urdfs import parity, relative, same_bounds, urdf_robot

pytestmark = pytest.mark.e2e

TOLERANCE = 1e-9


@pytest.mark.parametrize("count", [6, pytest.param(60, marks=pytest.mark.slow)])
def test_the_files_are_the_urdf(count):
    each(is_exact, count, urdfs())


def is_exact(text):
    robot = urdf_robot(text)
    with tempfile.TemporaryDirectory() as folder:
        files = write(robot, Path(folder)).files
        assert parity(text.encode(), robot, files, Path(folder)).worst < TOLERANCE
        assert not [check for check in checked(Path(folder), robot, plan_of()) if check.fails]
    assert not same_bounds(text.encode(), robot, files["robot.urdf"])


@pytest.mark.slow
def test_another_root_is_the_same_robot():
    each(has_another_root, 12, urdfs(), st.integers(0, 100))


def has_another_root(text, which):
    first = urdf_robot(text)
    if first.root.name == "world":
        return
    names = sorted(link.name for link in first.links)
    robot = urdf_robot(text, plan_of(root={"select": names[which % len(names)]}))
    with tempfile.TemporaryDirectory() as folder:
        assert failures(Path(folder), robot) == []
        engine = Mujoco(Path(folder) / "robot.xml")
    random = np.random.default_rng(which)
    q = {dof.name: float(random.uniform(-2, 2)) for dof in robot.dofs}
    mates = {joint.name: joint.mate.name for joint in robot.joints}
    true_poses = Pinocchio(text.encode()).poses({mates[name]: value for name, value in q.items()})
    poses = engine.poses(q)
    to_ours = poses[robot.root.name] @ np.linalg.inv(true_poses[robot.root.path[0]])
    # A link that was above its joint and now hangs on it has its frame there: its body is the same.
    for link in robot.links:
        actual = moved(link.inertial, poses[link.name])
        expected = moved(moved(first.link(link.name).inertial, true_poses[link.path[0]]), to_ours)
        assert np.abs(actual.com - expected.com).max() < TOLERANCE
        assert relative(actual.inertia, expected.inertia) < TOLERANCE
    for frame in robot.frames:
        off = poses[frame.link] @ frame.link_from_frame - to_ours @ true_poses[frame.source]
        assert np.abs(off).max() < TOLERANCE
    if robot.dofs:
        assert relative(*afloat(text, robot, engine, q)) < TOLERANCE


def afloat(text, robot, engine, q):
    """What the joints feel of the masses where nothing holds the root: M_jj − M_jb M_bb⁻¹ M_bj, which no
    choice of a root changes; of our MJCF, and of the file."""
    names = [dof.name for dof in robot.dofs]
    true_names = {joint.name: joint.mate.name for joint in robot.joints}
    engine.poses(q)
    full = np.zeros((engine.model.nv, engine.model.nv))
    mujoco.mj_fullM(engine.model, engine.data, full)
    ours = _eliminated(full, [int(engine.model.joint(name).dofadr[0]) for name in names])
    model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    value = pin.neutral(model)
    joints = [model.joints[model.getJointId(true_names[name])] for name in names]
    for joint, name in zip(joints, names, strict=True):
        numbers = [q[name]] if joint.nq == 1 else [np.cos(q[name]), np.sin(q[name])]
        value[joint.idx_q : joint.idx_q + joint.nq] = numbers
    upper = np.triu(pin.crba(model, model.createData(), value))
    return ours, _eliminated(upper + np.triu(upper, 1).T, [joint.idx_v for joint in joints])


def _eliminated(full, order):
    base = np.arange(6)
    across = full[np.ix_(base, order)]
    return full[np.ix_(order, order)] - across.T @ np.linalg.solve(full[np.ix_(base, base)], across)


def test_our_urdf_is_read_as_the_same_robot():
    each(comes_back, 30, urdfs())


def comes_back(text):
    first = urdf_robot(text)
    with tempfile.TemporaryDirectory() as folder:
        second = urdf_robot(write(first, Path(folder)).files["robot.urdf"])
    assert [link.name for link in second.links] == [link.name for link in first.links]
    assert [joint.name for joint in second.joints] == [joint.name for joint in first.joints]
    assert {frame.name for frame in second.frames} == {frame.name for frame in first.frames}
    assert [d.limits for d in second.dofs] == [d.limits for d in first.dofs]
    assert second.relations == first.relations
    for link, other in zip(second.links, first.links, strict=True):
        assert abs(link.inertial.mass - other.inertial.mass) < TOLERANCE
        assert np.abs(link.inertial.inertia - other.inertial.inertia).max() < TOLERANCE * 100


NAMES = ("{0}", "Link{0}", "arm/{0}", "l.{0}", "grüße {0}", "L-{0}")
ANGLES = (0.0, math.pi / 2, -math.pi / 2, math.pi, 0.3, -1.234567890123)
LENGTHS = (0.0, 0.1, -0.25, 1.0, 1e-3, 0.123456789012345)
AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1), (1, 1, 0), (0.3, -2, 0.7), (1e-9, 0, 1))


@st.composite
def urdfs(draw, most=8):
    """The text of a URDF whose moving links all have mass, or carry one that has."""
    count = draw(st.integers(1, most))
    style = draw(st.sampled_from(NAMES))
    clash = draw(st.booleans())
    names = [style.format(f"b{i}") for i in range(count)]
    if draw(st.booleans()):
        names[0] = "world"
    parents = [draw(st.integers(0, i - 1)) for i in range(1, count)]
    types = [draw(st.sampled_from(("fixed", "revolute", "continuous", "prismatic"))) for _ in parents]
    # A dummy is a leaf on a fixed joint, or has children that are fixed or moving: all of these merge.
    dummy = [False, *(kind == "fixed" and draw(st.booleans()) for kind in types)]
    lines = [_link(names[0], None if draw(st.booleans()) and count > 1 and names[0] == "world" else draw)]
    lines += [_link(name, None if dummy[i] else draw) for i, name in enumerate(names[1:], start=1)]
    joints = [name if clash else f"{name}_j" for name in names[1:]]
    movers = []
    for i, (parent, kind) in enumerate(zip(parents, types, strict=True)):
        mimic = draw(st.sampled_from(movers)) if movers and kind != "fixed" and draw(st.booleans()) else ""
        lines.append(_joint(draw, joints[i], kind, names[parent], names[i + 1], mimic))
        if kind != "fixed":
            movers.append(joints[i])
    if draw(st.booleans()):
        lines.reverse()
    return "\n".join(['<robot name="any">', *lines, "</robot>"])


def _pose(draw):
    xyz = [draw(st.sampled_from(LENGTHS)) for _ in range(3)]
    rpy = [draw(st.sampled_from(ANGLES)) for _ in range(3)]
    return f'<origin xyz="{_text(xyz)}" rpy="{_text(rpy)}"/>'


def _text(numbers):
    return " ".join(repr(float(number)) for number in numbers)


def _link(name, draw):
    if draw is None:
        return f'<link name="{name}"/>'
    mass = draw(st.sampled_from((0.01, 1.0, 12.5)))
    second = np.diag([draw(st.sampled_from((0.02, 0.3, 1.0))) for _ in range(3)]) * mass
    turn = Rotation.from_euler("xyz", [draw(st.sampled_from(ANGLES)) for _ in range(3)]).as_matrix()
    i = turn @ (np.trace(second) * np.eye(3) - second) @ turn.T
    numbers = {"ixx": i[0, 0], "ixy": i[0, 1], "ixz": i[0, 2], "iyy": i[1, 1], "iyz": i[1, 2], "izz": i[2, 2]}
    inertia = " ".join(f'{key}="{float(value)!r}"' for key, value in numbers.items())
    body = f'<mass value="{mass}"/><inertia {inertia}/>'
    return f'<link name="{name}"><inertial>{_pose(draw)}{body}</inertial></link>'


def _joint(draw, name, kind, parent, child, mimic):
    inside = [_pose(draw), f'<parent link="{parent}"/><child link="{child}"/>']
    if kind != "fixed":
        axis = np.array(draw(st.sampled_from(AXES)), dtype=float)
        inside.append(f'<axis xyz="{_text(axis / np.linalg.norm(axis))}"/>')
        low = draw(st.sampled_from((-2.5, -0.1, 0.0)))
        high = low + draw(st.sampled_from((0.5, 3.0)))
        span = "" if kind == "continuous" else f'lower="{low}" upper="{high}" '
        inside.append(f'<limit {span}effort="{draw(st.sampled_from((1, 7.5)))}" velocity="2"/>')
        if draw(st.booleans()):
            inside.append('<dynamics damping="0.1" friction="0.02"/>')
    if mimic:
        factor, offset = draw(st.sampled_from((1.0, -0.5, 3.0))), draw(st.sampled_from((0.0, 0.25, -4.0)))
        inside.append(f'<mimic joint="{mimic}" multiplier="{factor}" offset="{offset}"/>')
    return f'<joint name="{name}" type="{kind}">{"".join(inside)}</joint>'
