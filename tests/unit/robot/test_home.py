"""`home`: the pose nearest to the saved one within limits, relations and loops."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from linkwright.stages.robot.model.robot import Limits, Relation, Robot, frozen
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loops import across, closing, gap
from linkwright.stages.robot.motion.pose_batch import many_link_poses, repeated
from linkwright.stages.robot.motion.start_pose import home, nearest, saved
from tests.support.robots import EVERY, LOOPS, at, joint, loop, pose, robot_with, some_values

A, B, C = 0.1, 0.13, 0.12
"""Lengths [m] of a four-bar's crank, coupler and rocker; its base is 0.15 m long."""


def four_bar(limits: dict[str, Limits] | None = None, crank: float = 1.1) -> Robot:
    """A four-bar in the plane of x and y, closed by a hinge, saved at this angle of its crank."""
    far = np.array([A * math.cos(crank), A * math.sin(crank)]) - [0.15, 0]
    distance = math.hypot(*far)
    toward = math.atan2(-far[1], -far[0])
    inner = math.acos((B * B + distance * distance - C * C) / (2 * B * distance))
    tip = far + B * np.array([math.cos(toward - inner), math.sin(toward - inner)])
    rocker = math.atan2(tip[1], tip[0])
    coupler = math.atan2(*(tip - far)[::-1])
    joints = [
        joint("revolute", "base", "crank", name="drive", saved=[crank], limits=limits),
        joint(
            "revolute",
            "crank",
            "coupler",
            place=at(A, 0, 0),
            name="pin",
            saved=[coupler - crank],
            limits=limits,
        ),
        joint(
            "revolute", "base", "rocker", place=at(0.15, 0, 0), name="swing", saved=[rocker], limits=limits
        ),
    ]
    end = loop("revolute", "coupler", "rocker", at(B, 0, 0), at(C, 0, 0), saved=[coupler - rocker])
    robot = robot_with(joints, loops=[end])
    assert gap(robot.loops[0], link_poses(robot, saved(robot))) < 1e-12
    return robot


def reordered(robot: Robot) -> Robot:
    """The four-bar with its joints and links in another order."""
    drive, pin, swing = robot.joints
    links = {link.name: link for link in robot.links}
    order = ("base", "rocker", "crank", "coupler")
    return replace(robot, joints=(swing, drive, pin), links=tuple(links[name] for name in order))


def test_home_is_the_saved_pose_where_that_is_within_the_limits():
    robot = four_bar({"drive": Limits(0.0, 1.1)})
    assert home(robot) == saved(robot)


def test_home_closes_the_loop_within_the_limits_and_is_the_nearest():
    robot = four_bar({"drive": Limits(1.3, 2.0), "swing": Limits(-3.0, 3.0)})
    found = home(robot)
    poses = link_poses(robot, found)
    assert gap(robot.loops[0], poses) < 1e-9
    assert found["drive"] == pytest.approx(1.3, abs=1e-9)
    start = saved(robot)
    names = ["drive", "pin", "swing", "loop"]
    shares = {"drive": 0.7, "pin": 2 * math.pi, "swing": 6.0, "loop": 2 * math.pi}

    def open_by(x):
        values = dict(zip(names, x, strict=True))
        off = across(robot.loops[0], link_poses(robot, values))
        own = closing(robot.loops[0], off)["loop"]
        return [*off[:2, 3] * 10, own - values["loop"]]

    oracle = minimize(
        lambda x: sum(((x[i] - start[name]) / shares[name]) ** 2 for i, name in enumerate(names)),
        [start[name] for name in names],
        method="SLSQP",
        bounds=[(1.3, 2.0), (None, None), (-3, 3), (None, None)],
        constraints={"type": "eq", "fun": open_by},
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert oracle.success
    assert [found[name] for name in names] == pytest.approx(oracle.x, abs=1e-5)


def test_home_where_another_dof_of_the_loop_is_at_its_limit():
    free = four_bar()
    swing = saved(free)["swing"]
    robot = four_bar({"swing": Limits(swing + 0.1, None)})
    found = home(robot)
    assert found["swing"] == pytest.approx(swing + 0.1, abs=1e-12)
    assert gap(robot.loops[0], link_poses(robot, found)) < 1e-9


def test_limits_that_no_closed_pose_fulfils_are_kept_and_the_loop_stays_open():
    far = saved(four_bar())
    limits = {
        "drive": Limits(1.3, 2.0),
        "pin": Limits(far["pin"] + 2, None),
        "swing": Limits(None, far["swing"] - 2),
    }
    robot = four_bar(limits)
    found = home(robot)
    for name, limit in limits.items():
        assert limit.contains(found[name])
    assert gap(robot.loops[0], link_poses(robot, found)) > 1e-3


def test_a_driver_stops_where_its_follower_does():
    joints = [
        joint("revolute", "base", "one", saved=[1.0], limits={"one_joint": Limits(-2.0, 2.0)}),
        joint("revolute", "base", "two", saved=[-2.5], limits={"two_joint": Limits(-1.0, 1.0)}),
    ]
    robot = robot_with(joints, relations=[Relation("gear", "two_joint", "one_joint", -2.0, -0.5)])
    assert ranges(robot) == {"one_joint": (-0.75, 0.25), "two_joint": (-1.0, 1.0)}
    assert home(robot) == {"one_joint": 0.25, "two_joint": -1.0}


def test_given_values_hold_and_the_rest_of_the_loop_follows():
    robot = four_bar({"drive": Limits(0.0, 2.0)})
    found = nearest(robot, saved(robot), {"drive": 0.9})
    assert found["drive"] == 0.9
    assert gap(robot.loops[0], link_poses(robot, found)) < 1e-9


def test_home_does_not_depend_on_the_order_of_joints_and_loops():
    robot = four_bar({"drive": Limits(1.3, 2.0)})
    assert home(reordered(robot)) == home(robot)


@pytest.mark.parametrize("kind", EVERY)
def test_many_poses_at_once_are_those_one_by_one(kind):
    rng = np.random.default_rng(5)
    origins = [frozen(pose(rng)) for _ in range(3)]
    joints = [
        joint(kind, "base", "one", place=pose(rng), backwards=True, origins=origins),
        joint("revolute", "one", "two", place=pose(rng)),
    ]
    robot = robot_with(joints)
    rows = [some_values(robot, rng) for _ in range(3)]
    batch = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    together = many_link_poses(robot, batch)
    for index, row in enumerate(rows):
        for link, found in link_poses(robot, row).items():
            np.testing.assert_allclose(together[link][index], found, atol=1e-14)


@pytest.mark.parametrize("kind", LOOPS)
def test_every_type_of_loop_closes_from_near_by(kind):
    """A closed chain of many dofs, whose values are then shaken: it closes again."""
    rng = np.random.default_rng(11)
    joints = [
        joint("ball", "base", "one", place=pose(rng)),
        joint("planar", "one", "two", place=pose(rng)),
        joint("cylindrical", "base", "three", place=pose(rng)),
        joint("ball", "three", "four", place=pose(rng)),
    ]
    bare = robot_with(joints)
    poses = link_poses(bare)
    end = poses["two"] @ pose(rng)
    fit = [np.linalg.inv(poses[link]) @ end for link in ("two", "four")]
    robot = robot_with(joints, loops=[loop(kind, "two", "four", *map(frozen, fit))])
    values = repeated(saved(robot), 4)
    for value in values.values():
        value += rng.normal(scale=0.05, size=value.shape)
    settled, closed = Closer(robot).settled(values)
    assert closed.all()
    for row in range(4):
        one = {name: float(v[row]) if v.ndim == 1 else tuple(v[row]) for name, v in settled.items()}
        assert gap(robot.loops[0], link_poses(robot, one)) < 1e-6
