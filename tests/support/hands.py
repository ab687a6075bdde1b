"""Hands of light links in closed loops, which nothing damps: the most that a robot asks of a simulation."""

import numpy as np

from linkwright.stages.robot.model.robot import Inertial, frozen
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from tests.support.robots import at, joint, loop, robot_with

ACROSS = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0.0], [0, 0, 0, 1]])
"""A joint's frame with its z axis across gravity."""

BAR, RADIUS = 0.03, 0.002


def hand(seed, fingers=4, stages=2, mass=0.005, closing="revolute", dynamics=None):
    """Fingers of four-bar linkages in a row, each bar of about `mass` [kg] and 3 cm; `closing` is the type of
    the mate that closes each. With revolute ones there are 2 · fingers · stages equalities."""
    rng = np.random.default_rng(seed)
    joints = []
    inertials = {}
    closed = []
    for finger in range(fingers):
        above, frame = "base", at(0, BAR * finger, 0) @ ACROSS
        for stage in range(stages):
            lower, upper, coupler = (f"f{finger}{stage}_{name}" for name in ("lower", "upper", "coupler"))
            first, second = rng.uniform(0.5, 1.5, 2) * BAR
            width, shift = rng.uniform(0.2, 0.6) * BAR, rng.uniform(-0.3, 0.3) * BAR
            places = {lower: (above, frame), upper: (above, frame @ at(shift, width, 0))}
            places[coupler] = (lower, at(first, 0, 0))
            for (name, (parent, place)), length in zip(places.items(), (first, second, width), strict=True):
                value = float(rng.uniform(-0.8, 0.8))
                joints.append(joint("revolute", parent, name, [value], place=place, dynamics=dynamics))
                inertials[name] = rod(mass * rng.uniform(0.3, 1.5), length)
            closed.append((upper, coupler, at(second, 0, 0), width))
            above, frame = coupler, at(0.3 * width, 0, 0)
    bare = robot_with(joints, inertials=inertials)
    poses = link_poses(bare, saved_configuration(bare))
    loops = []
    for number, (first, other, end, lever) in enumerate(closed):
        met = np.linalg.inv(poses[other]) @ poses[first] @ end
        loops.append(
            loop(closing, first, other, end, met, name=f"loop{number}", lever=lever, solref=(0.005, 1.0))
        )
    return robot_with(joints, loops=loops, inertials=inertials)


def rod(mass, length):
    """A solid cylinder along x."""
    along, across = mass * RADIUS**2 / 2, mass * (3 * RADIUS**2 + length**2) / 12
    return Inertial(mass, frozen((length / 2, 0, 0)), frozen(np.diag([along, across, across])))
