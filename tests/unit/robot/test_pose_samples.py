"""Seeded poses: within limits, by the relations, with loops closed, the same ones every time."""

import math

import numpy as np
import pytest

from linkwright.stages.robot.model.poses import rotation_from_quat
from linkwright.stages.robot.model.robot import Limits, Relation
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loops import gap
from linkwright.stages.robot.motion.pose_batch import count_of
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home
from tests.support.robots import EVERY, joint, robot_with
from tests.unit.robot.test_home import four_bar, reordered


def is_uniform(values):
    """Whether values may be drawn evenly from 0 to 1."""
    # Here, since only one of the workers has to wait for the import.
    from scipy.stats import kstest

    return kstest(values, "uniform").pvalue > 1e-3


def sampled(robot, count=200, reach=0.5):
    return sampled_poses(robot, count, reach, home(robot))


def row(values, index):
    return {n: float(v[index]) if v.ndim == 1 else tuple(v[index]) for n, v in values.items()}


def test_scalars_are_spread_evenly_over_their_ranges():
    ranges = {
        "limited": ("revolute", Limits(-0.2, 1.0), (-0.2, 1.0)),
        "whole": ("revolute", Limits(), (-math.pi + 0.3, math.pi + 0.3)),
        "upper": ("revolute", Limits(None, 1.0), (1.0 - 2 * math.pi, 1.0)),
        "slide": ("prismatic", Limits(), (-0.2, 0.8)),
        "lower": ("prismatic", Limits(0.1, None), (0.1, 1.1)),
    }
    limits = {name: row[1] for name, row in ranges.items()}
    joints = [
        joint(kind, "base", f"{name}_link", [0.3], name=name, limits=limits)
        for name, (kind, _, _) in ranges.items()
    ]
    values = sampled(robot_with(joints), 2000)
    for name, (_, _, (low, high)) in ranges.items():
        assert low <= values[name].min() <= values[name].max() <= high, name
        assert is_uniform((values[name] - low) / (high - low)), name
    assert abs(np.corrcoef(values["limited"], values["slide"])[0, 1]) < 0.1


def test_another_salt_draws_poses_that_are_not_these():
    robot = robot_with([joint("revolute", "base", "arm", limits={"arm_joint": Limits(-1.0, 1.0)})])
    start = home(robot)
    drawn = [sampled_poses(robot, 2000, 0.5, start, salt)["arm_joint"] for salt in ("", "", "other")]
    assert (drawn[0] == drawn[1]).all()
    assert not np.isin(drawn[2], drawn[0]).any()
    assert abs(np.corrcoef(drawn[0], drawn[2])[0, 1]) < 0.1


@pytest.mark.parametrize("cone", [None, 0.6])
def test_ball_fills_its_cone(cone):
    robot = robot_with([joint("ball", "base", "one", limits={"one_joint": Limits(None, cone)})])
    turns = np.array([rotation_from_quat(quat) for quat in sampled(robot, 2000)["one_joint"]])
    heights, lowest = turns[:, 2, 2], -1.0 if cone is None else math.cos(cone)
    assert (heights >= lowest - 1e-12).all()
    # The height of an even spread over a sphere's cap is even (Archimedes), and so is the twist about it.
    assert is_uniform((heights - lowest) / (1 - lowest))
    around = np.arctan2(turns[:, 1, 2], turns[:, 0, 2])
    twists = np.arctan2(turns[:, 1, 0] - turns[:, 0, 1], turns[:, 0, 0] + turns[:, 1, 1])
    for angles in (around, twists):
        assert is_uniform(angles / (2 * math.pi) + 0.5)


def test_followers_follow_and_stay_within_their_limits():
    limits = {"one_joint": Limits(-2.0, 2.0), "two_joint": Limits(-0.01, 0.02)}
    joints = [
        joint("revolute", "base", "one", limits=limits),
        joint("prismatic", "base", "two", limits=limits),
    ]
    robot = robot_with(joints, relations=[Relation("rack", "two_joint", "one_joint", -0.1, 0.0)])
    values = sampled(robot)
    np.testing.assert_array_equal(values["two_joint"], -0.1 * values["one_joint"])
    assert values["one_joint"].min() < -0.19
    assert values["one_joint"].max() > 0.09
    assert -0.01 - 1e-15 <= values["two_joint"].min() <= values["two_joint"].max() <= 0.02 + 1e-15


def test_loops_are_closed_within_limits_and_do_not_fold_over():
    limits = {"drive": Limits(0.6, 1.7), "swing": Limits(0.0, 3.0)}
    robot = four_bar(limits)
    values = sampled(robot)
    assert count_of(values) == 200
    for index in range(200):
        q = row(values, index)
        assert gap(robot.loops[0], link_poses(robot, q)) < 1e-6
        assert all(limits[name].contains(q[name], 1e-12) for name in limits)
    assert np.ptp(values["drive"]) > 0.9
    # The elbow stays on its side: sin of the angle between coupler and rocker keeps its sign.
    assert len(set(np.sign(np.sin(values["loop"])))) == 1


def test_loop_that_is_open_at_the_start_gives_no_open_poses():
    robot = four_bar({"drive": Limits(0.6, 0.7), "swing": Limits(-3.0, -2.9), "pin": Limits(2.9, 3.0)})
    values = sampled(robot, 20)
    assert all(gap(robot.loops[0], link_poses(robot, row(values, i))) < 1e-6 for i in range(count_of(values)))
    assert count_of(values) == 0


@pytest.mark.parametrize("kind", EVERY)
def test_every_type_of_joint_has_poses_and_all_of_its_dofs_move(kind):
    values = sampled(robot_with([joint(kind, "base", "one")]), 8)
    assert all(np.ptp(value, axis=0).min() > 0 for value in values.values())
    assert all(len(value) == 8 for value in values.values())


def test_poses_do_not_depend_on_the_order_of_joints():
    robot = four_bar({"drive": Limits(0.6, 1.7)})
    first, second = sampled(robot, 20), sampled(reordered(robot), 20)
    for name, value in first.items():
        np.testing.assert_array_equal(value, second[name])


def test_new_joint_does_not_change_the_poses_of_others():
    row = joint("revolute", "base", "one")
    single, both = robot_with([row]), robot_with([joint("ball", "base", "zero"), row])
    np.testing.assert_array_equal(sampled(single)["one_joint"], sampled(both)["one_joint"])
