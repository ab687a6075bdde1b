"""`home`, the pose nearest to the saved one within limits, relations and loops; mechanisms of loops."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from linkwright.stages.robot.model.robot import Limits, Relation, frozen
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.couplings import Couplings
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loop_groups import LoopGroups
from linkwright.stages.robot.motion.loops import closing_values, gap, relative_pose
from linkwright.stages.robot.motion.pose_batch import many_link_poses, repeated
from linkwright.stages.robot.motion.start_pose import home, nearest, saved
from tests.support.robots import EVERY, LOOPS, at, joint, loop, pose, robot_around, robot_with, some_values

A, B, C = 0.1, 0.13, 0.12
"""Lengths [m] of a four-bar's crank, coupler and rocker; its base is 0.15 m long."""


def four_bar(limits=None, crank=1.1):
    """A four-bar in the plane of x and y, closed by a hinge, saved at this angle of its crank."""
    far = np.array([A * math.cos(crank), A * math.sin(crank)]) - [0.15, 0]
    distance = math.hypot(*far)
    toward = math.atan2(-far[1], -far[0])
    inner = math.acos((B * B + distance * distance - C * C) / (2 * B * distance))
    tip = far + B * np.array([math.cos(toward - inner), math.sin(toward - inner)])
    rocker = math.atan2(tip[1], tip[0])
    coupler = math.atan2(*(tip - far)[::-1])
    rows = (
        ("base", "crank", "drive", 0, crank),
        ("crank", "coupler", "pin", A, coupler - crank),
        ("base", "rocker", "swing", 0.15, rocker),
    )
    joints = [
        joint("revolute", above, below, [saved], name=name, place=at(x, 0, 0), limits=limits)
        for above, below, name, x, saved in rows
    ]
    end = loop("revolute", "coupler", "rocker", at(B, 0, 0), at(C, 0, 0), saved=[coupler - rocker])
    robot = robot_with(joints, loops=[end])
    assert opening(robot, saved(robot)) < 1e-12
    return robot


def opening(robot, q):
    """How far the loop is open [m or rad]."""
    return gap(robot.loops[0], link_poses(robot, q))


def reordered(robot):
    """The four-bar with its joints and links in another order."""
    drive, pin, swing = robot.joints
    links = {link.name: link for link in robot.links}
    order = ("base", "rocker", "crank", "coupler")
    return replace(robot, joints=(swing, drive, pin), links=tuple(links[name] for name in order))


def test_home_is_the_saved_pose_where_that_is_within_the_limits():
    robot = four_bar({"drive": Limits(0.0, 1.1)})
    assert home(robot) == saved(robot)


def test_home_closes_the_loop_and_is_the_nearest_pose():
    robot = four_bar({"drive": Limits(1.3, 2.0), "swing": Limits(-3.0, 3.0)})
    nearest_pose, start = home(robot), saved(robot)
    assert opening(robot, nearest_pose) < 1e-9
    assert nearest_pose["drive"] == pytest.approx(1.3, abs=1e-9)
    shares = {"drive": 0.7, "pin": 2 * math.pi, "swing": 6.0, "loop": 2 * math.pi}

    def open_by(x):
        values = dict(zip(shares, x, strict=True))
        off = relative_pose(robot.loops[0], link_poses(robot, values))
        return [*off[:2, 3] * 10, closing_values(robot.loops[0], off)["loop"] - values["loop"]]

    oracle = minimize(
        lambda x: sum(((q - start[name]) / shares[name]) ** 2 for name, q in zip(shares, x, strict=True)),
        [start[name] for name in shares],
        method="SLSQP",
        bounds=[(1.3, 2.0), (None, None), (-3, 3), (None, None)],
        constraints={"type": "eq", "fun": open_by},
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert oracle.success
    assert [nearest_pose[name] for name in shares] == pytest.approx(oracle.x, abs=1e-5)


def test_home_where_another_dof_of_the_loop_is_at_its_limit():
    swing = saved(four_bar())["swing"]
    robot = four_bar({"swing": Limits(swing + 0.1, None)})
    assert home(robot)["swing"] == pytest.approx(swing + 0.1, abs=1e-12)
    assert opening(robot, home(robot)) < 1e-9


def test_limits_that_no_closed_pose_fulfils_leave_the_loop_open():
    far, drive = saved(four_bar()), Limits(1.3, 2.0)
    limits = {"drive": drive, "pin": Limits(far["pin"] + 2, None), "swing": Limits(None, far["swing"] - 2)}
    robot = four_bar(limits)
    assert all(limit.contains(home(robot)[name]) for name, limit in limits.items())
    assert opening(robot, home(robot)) > 1e-3


def test_driver_stops_where_its_follower_does():
    joints = [
        joint("revolute", "base", "one", saved=[1.0], limits={"one_joint": Limits(-2.0, 2.0)}),
        joint("revolute", "base", "two", saved=[-2.5], limits={"two_joint": Limits(-1.0, 1.0)}),
    ]
    robot = robot_with(joints, relations=[Relation("gear", "two_joint", "one_joint", -2.0, -0.5)])
    assert ranges(robot) == {"one_joint": (-0.75, 0.25), "two_joint": (-1.0, 1.0)}
    assert home(robot) == {"one_joint": 0.25, "two_joint": -1.0}


def test_given_values_hold_and_the_rest_of_the_loop_follows():
    robot = four_bar({"drive": Limits(0.0, 2.0)})
    pose = nearest(robot, saved(robot), {"drive": 0.9})
    assert pose["drive"] == 0.9
    assert opening(robot, pose) < 1e-9


def test_home_does_not_depend_on_the_order_of_joints_and_loops():
    robot = four_bar({"drive": Limits(1.3, 2.0)})
    assert home(reordered(robot)) == home(robot)


@pytest.mark.parametrize("kind", EVERY)
def test_poses_of_many_rows_are_those_of_single_rows(kind):
    rng = np.random.default_rng(5)
    robot = robot_around(kind, rng, "base", backwards=True)
    rows = [some_values(robot, rng) for _ in range(3)]
    together = many_link_poses(robot, {name: np.array([row[name] for row in rows]) for name in rows[0]})
    for index, row in enumerate(rows):
        for link, expected in link_poses(robot, row).items():
            np.testing.assert_allclose(together[link][index], expected, atol=1e-14)


@pytest.mark.parametrize("kind", LOOPS)
def test_every_type_of_loop_closes_from_near_by(kind):
    """A closed chain of many dofs, whose values are then shaken: it closes again."""
    rng = np.random.default_rng(11)
    rows = ("ball base one", "planar one two", "cylindrical base three", "ball three four")
    joints = [joint(*row.split(), place=pose(rng)) for row in rows]
    poses = link_poses(robot_with(joints))
    end = poses["two"] @ pose(rng)
    fit = [frozen(np.linalg.inv(poses[link]) @ end) for link in ("two", "four")]
    robot = robot_with(joints, loops=[loop(kind, "two", "four", *fit)])
    values = repeated(saved(robot), 4)
    for value in values.values():
        value += rng.normal(scale=0.05, size=value.shape)
    settled, closed = Closer(robot).settled(values)
    assert closed.all()
    for row in range(4):
        q = {name: float(v[row]) if v.ndim == 1 else tuple(v[row]) for name, v in settled.items()}
        assert opening(robot, q) < 1e-6


def gears(driver_above):
    """A loop of `left` and `right`, of which `left` follows a joint that is above both, or beside them."""
    rows = (("base", "arm", "shoulder"), ("base", "aside", "beside"))
    rows += (("arm", "left", "to_left"), ("arm", "right", "to_right"))
    return robot_with(
        [joint("revolute", above, below, name=name) for above, below, name in rows],
        loops=[loop("revolute", "left", "right", np.eye(4), np.eye(4))],
        relations=[Relation("gear", "to_left", "shoulder" if driver_above else "beside", 2.0, 0.0)],
    )


@pytest.mark.parametrize("driver_above", [True, False])
def test_driver_is_in_the_mechanism_wherever_it_is(driver_above):
    (mechanism,) = LoopGroups(gears(driver_above)).mechanisms()
    dofs = {dof.name for joint in mechanism.joints for dof in joint.dofs}
    assert {name for relation in mechanism.relations for name in (relation.driver, relation.follower)} <= dofs
    moved = {"shoulder" if driver_above else "beside", "to_right"}
    assert moved <= set(Closer(mechanism).names)


def four_bar_with_a_slide(rng):
    """A planar four-bar, turned at random, whose crank has a slide across the plane, which cannot move."""
    turned = pose(rng)
    joints = [
        joint("revolute", "base", "crank", name="drive", place=turned),
        joint("prismatic", "crank", "carriage", name="across"),
        joint("revolute", "carriage", "coupler", name="pin", place=at(0.1, 0, 0)),
        joint("revolute", "coupler", "rocker", name="knee", place=at(0, 0.07, 0)),
    ]
    askew = pose(rng)
    askew[:3, 3] = 0.0
    end = loop("ball", "rocker", "base", at(-0.12, 0, 0) @ askew, turned @ at(-0.02, 0.07, 0) @ askew)
    return robot_with(joints, loops=[end])


@pytest.mark.parametrize("seed", range(20))
def test_dof_that_cannot_move_is_not_driven(seed):
    robot = four_bar_with_a_slide(np.random.default_rng(seed))
    assert gap(robot.loops[0], link_poses(robot, saved(robot))) < 1e-12
    couplings = Couplings(robot, repeated(saved(robot), 1))
    assert couplings.independent(["across", "drive", "pin", "knee"]) == ("drive",)
