"""Where q counts from: the saved pose as zero, for every type of joint and loop."""

import numpy as np
import pytest

from linkwright.stages.graph.passes.zero_pose import with_zero
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import at_rest, rotation_from_quat
from linkwright.stages.robot.model.robot import Limits, Relation, Robot
from linkwright.stages.robot.motion.kinematics import (
    chain,
    link_poses,
    rest_configuration,
    saved_configuration,
)
from tests.support.reported import reports
from tests.support.robots import CHAINS, EVERY, LOOPS, joint, loop, pose, robot_with, some_value, some_values


def zeroed(robot: Robot, log: Diagnostics) -> Robot:
    """The robot with q = 0 at the saved pose."""
    return with_zero(robot, "saved", {}, log)


def product(first, other):
    """Hamilton's product of quaternions (w, x, y, z)."""
    (a, b, c, d), (e, f, g, h) = first, other
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


def after(saved, q):
    """The value that moves as `saved` does and then as `q`."""
    if isinstance(saved, float):
        return saved + q
    if len(saved) == 4:
        return product(saved, q)
    place = rotation_from_quat(np.array(saved[3:])) @ np.array(q[:3]) + np.array(saved[:3])
    return (*map(float, place), *product(saved[3:], q[3:]))


def every_joint(seed: int) -> Robot:
    """A chain of all types, forwards, backwards and mirrored, saved somewhere, with origins between."""
    rng = np.random.default_rng(seed)
    joints, parent = [], "base"
    for number, kind in enumerate(kind for kind in EVERY for _ in range(3)):
        name = f"link_{number}"
        values = [some_value(freedom, rng) for _, freedom, _ in CHAINS[kind]]
        origins = [pose(rng) for _ in CHAINS[kind][1:]]
        way = {"backwards": number % 3 == 1, "mirrored": number % 3 == 2}
        joints.append(joint(kind, parent, name, values, place=pose(rng), origins=origins, **way))
        parent = name
    loops = []
    for kind in LOOPS:
        frames, values = (pose(rng), pose(rng)), [some_value(freedom, rng) for _, freedom, _ in CHAINS[kind]]
        loops.append(loop(kind, "link_1", "link_4", *frames, values, name=f"loop_{kind}"))
    return robot_with(joints, loops=loops)


@pytest.mark.parametrize("seed", range(3))
def test_links_stay_at_values_counted_from_the_saved_pose(seed):
    robot = every_joint(seed)
    moved = zeroed(robot, Diagnostics())
    q = some_values(robot, np.random.default_rng(seed + 100))
    saved = saved_configuration(robot)
    both = {name: after(saved[name], q[name]) for name in q}
    want = link_poses(robot, both)
    for name, place in link_poses(moved, q).items():
        assert np.abs(place - want[name]).max() < 1e-9
    want = link_poses(robot, saved)
    for name, place in link_poses(moved, rest_configuration(moved)).items():
        assert np.abs(place - want[name]).max() < 1e-12
    assert all(dof.saved == at_rest(dof.kind) for dof in moved.dofs)
    assert all((j.dofs[0].origin == np.eye(4)).all() for j in moved.joints if j.dofs)


def test_loops_close_at_values_counted_from_the_saved_pose():
    rng = np.random.default_rng(7)
    robot = every_joint(3)
    for before, now in zip(robot.loops, zeroed(robot, Diagnostics()).loops, strict=True):
        q = {dof.name: some_value(dof.kind, rng) for dof in before.dofs}
        both = {dof.name: after(dof.saved, q[dof.name]) for dof in before.dofs}
        shut = before.b_from_frame @ chain(before.dofs, both)
        assert np.abs(now.b_from_frame @ chain(now.dofs, q) - shut).max() < 1e-12
        assert (now.a_from_frame == before.a_from_frame).all()


def test_limits_and_relations_say_the_same_of_the_shifted_values():
    limits = {"one_joint": Limits(-1.0, None), "two_joint": Limits(0.1, 0.4)}
    joints = [
        joint("revolute", "base", "one", [0.5], limits=limits),
        joint("prismatic", "base", "two", [0.1], limits=limits, backwards=True),
        joint("revolute", "base", "three", [-1.3]),
    ]
    relations = [
        Relation("a", "two_joint", "one_joint", 0.2, 1e-17),
        Relation("b", "three_joint", "one_joint", -2.0, 0.7),
    ]
    robot = robot_with(joints, relations=relations)
    moved = zeroed(robot, Diagnostics())
    assert [dof.limits for dof in moved.dofs] == [Limits(-1.5, None), Limits(0.0, 0.4 - 0.1), Limits()]
    q, saved = 0.37, saved_configuration(robot)
    for before, now in zip(robot.relations, moved.relations, strict=True):
        want = before.multiplier * (saved["one_joint"] + q) + before.offset - saved[before.follower]
        assert now.multiplier * q + now.offset == pytest.approx(want, abs=1e-12)
    # −2 · 0.5 + 0.7 + 1.3 is the one relation that its saved pose breaks: by 1.
    assert [relation.offset for relation in moved.relations] == [0.0, pytest.approx(1.0)]


def test_a_ball_with_a_cone_keeps_its_zero_and_says_so():
    turned, limits = (0.8, 0.6, 0.0, 0.0), {"one_joint": Limits(None, 2.0)}
    for saved, expected in (([turned], [("W-ZERO", "one_joint")]), (None, [])):
        log = Diagnostics()
        (dof,) = zeroed(robot_with([joint("ball", "base", "one", saved, limits=limits)]), log).dofs
        assert (dof.limits, reports(log)) == (limits["one_joint"], expected)
        assert saved is None or dof.saved == turned
