"""Which dofs of closed loops can be driven at once."""

import numpy as np
import pytest

from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.couplings import Couplings
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loops import gap
from linkwright.stages.robot.motion.pose_batch import repeated
from linkwright.stages.robot.motion.start_pose import saved
from tests.support.robots import at, joint, loop, pose, robot_with


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
def test_a_dof_that_cannot_move_is_not_driven(seed: int) -> None:
    robot = four_bar_with_a_slide(np.random.default_rng(seed))
    assert gap(robot.loops[0], link_poses(robot, saved(robot))) < 1e-12
    couplings = Couplings(robot, repeated(saved(robot), 1))
    assert couplings.independent(["across", "drive", "pin", "knee"]) == ("drive",)
