"""Mechanisms of loops: each has all that moves its loops, and which of their dofs can be driven at once."""

import numpy as np
import pytest

from linkwright.stages.robot.model.robot import Relation, Robot
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.couplings import Couplings
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loop_groups import LoopGroups
from linkwright.stages.robot.motion.loops import gap
from linkwright.stages.robot.motion.pose_batch import repeated
from linkwright.stages.robot.motion.start_pose import saved
from tests.support.robots import at, joint, loop, pose, robot_with


def gears(driver_above: bool) -> Robot:
    """A loop of `left` and `right`, of which `left` follows a joint that is above both, or beside them."""
    rows = (("base", "arm", "shoulder"), ("base", "aside", "beside"))
    rows += (("arm", "left", "to_left"), ("arm", "right", "to_right"))
    return robot_with(
        [joint("revolute", above, below, name=name) for above, below, name in rows],
        loops=[loop("revolute", "left", "right", np.eye(4), np.eye(4))],
        relations=[Relation("gear", "to_left", "shoulder" if driver_above else "beside", 2.0, 0.0)],
    )


@pytest.mark.parametrize("driver_above", [True, False])
def test_a_driver_is_in_the_mechanism_wherever_it_is(driver_above):
    (mechanism,) = LoopGroups(gears(driver_above)).mechanisms()
    dofs = {dof.name for joint in mechanism.joints for dof in joint.dofs}
    assert {name for relation in mechanism.relations for name in (relation.driver, relation.follower)} <= dofs
    moved = {"shoulder" if driver_above else "beside", "to_right"}
    assert moved <= set(Closer(mechanism).names)


def four_bar_with_a_slide(rng: np.random.Generator) -> Robot:
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
def test_a_dof_that_cannot_move_is_not_driven(seed):
    robot = four_bar_with_a_slide(np.random.default_rng(seed))
    assert gap(robot.loops[0], link_poses(robot, saved(robot))) < 1e-12
    couplings = Couplings(robot, repeated(saved(robot), 1))
    assert couplings.independent(["across", "drive", "pin", "knee"]) == ("drive",)
