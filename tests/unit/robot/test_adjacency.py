"""Which links are next to each other."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from linkwright.stages.robot.model.robot import MeshRef
from linkwright.stages.robot.motion.adjacency import adjacent_pairs
from tests.support.robots import EVERY, LOOPS, joint, loop, robot_with

HELD = tuple(kind for kind in EVERY if kind != "free")


def pairs(robot, *without):
    return set(adjacent_pairs(robot, {link.name for link in robot.links} - set(without)))


@pytest.mark.parametrize("kind", HELD)
@pytest.mark.parametrize("fixed", [True, False])
def test_links_joined_by_a_joint_are_adjacent(kind, fixed):
    robot = robot_with([joint(kind, "base", "one"), joint("revolute", "one", "two")], fixed=fixed)
    rigid = kind == "fixed" and not fixed
    assert pairs(robot) == {("base", "one"), ("one", "two")} | ({("base", "two")} if rigid else set())


def test_a_free_joint_joins_nothing():
    robot = robot_with([joint("free", "world", "one"), joint("ball", "one", "two")], root="world")
    assert pairs(robot) == {("one", "two")}


@pytest.mark.parametrize("kind", LOOPS)
def test_links_joined_by_a_loop_are_adjacent(kind):
    joints = [joint("revolute", "base", name) for name in ("one", "two")]
    robot = robot_with(joints, loops=[loop(kind, "two", "one", np.eye(4), np.eye(4))])
    assert pairs(robot) == {("base", "one"), ("base", "two"), ("one", "two")}


def chain(*names, kind="revolute", fixed=True):
    return robot_with([joint(kind, *pair) for pair in pairwise(names)], root=names[0], fixed=fixed)


def test_links_without_a_collider_are_passed_through():
    robot = chain("a", "b", "c", "d")
    assert pairs(robot, "b") == {("a", "c"), ("c", "d")}
    assert pairs(robot, "b", "c") == {("a", "d")}


def test_of_links_that_are_seen_but_have_no_collider_only_one_is_passed_through():
    robot = chain("trunk", "upper", "fore", "hand")

    def seen(names):
        parts = {link.name: replace(link.parts[0], mesh=MeshRef("r", "p")) for link in robot.links}
        links = (replace(one, parts=(parts[one.name],)) if one.name in names else one for one in robot.links)
        return replace(robot, links=tuple(links))

    assert pairs(seen(["upper"]), "upper", "fore") == {("trunk", "hand")}
    assert pairs(seen(["upper", "fore"]), "upper", "fore") == set()
    assert pairs(seen(["upper", "fore"]), "fore") == {("trunk", "upper"), ("upper", "hand")}


def test_of_a_chain_it_does_not_matter_which_end_is_the_root():
    robot = robot_with([joint("revolute", "b", "a"), joint("revolute", "b", "c")], root="b")
    assert pairs(robot, "b") == {("a", "c")}


def test_fingers_of_a_hand_without_a_collider_are_not_adjacent():
    joints = [joint("revolute", "wrist", "hand")] + [joint("prismatic", "hand", f) for f in ("left", "right")]
    assert pairs(robot_with(joints, root="wrist"), "hand") == {("wrist", "left"), ("wrist", "right")}


def test_a_loop_through_a_link_without_a_collider():
    joints = [
        joint("revolute", "base", "crank"),
        joint("revolute", "base", "rocker"),
        joint("revolute", "crank", "rod"),
    ]
    robot = robot_with(joints, loops=[loop("revolute", "rod", "rocker", np.eye(4), np.eye(4))])
    assert pairs(robot, "rod") == {("base", "crank"), ("base", "rocker"), ("crank", "rocker")}


def test_rigid_links_count_as_one_body():
    joints = [
        joint("revolute", "base", "arm"),
        joint("fixed", "arm", "cover"),
        joint("revolute", "cover", "hand"),
        joint("fixed", "hand", "pad"),
    ]
    inner = {
        ("arm", "cover"),
        ("hand", "pad"),
        ("arm", "hand"),
        ("arm", "pad"),
        ("cover", "hand"),
        ("cover", "pad"),
    }
    assert pairs(robot_with(joints)) == inner | {("base", "arm"), ("base", "cover")}
    # A rigid body collides where one of its links does: neither of two legs is next to the other.
    assert ("base", "hand") not in pairs(robot_with(joints), "arm")


def test_of_a_fixed_workplace_only_the_link_with_the_joint_is_adjacent():
    joints = [
        joint("fixed", "table", "stand"),
        joint("fixed", "table", "fence"),
        joint("revolute", "stand", "arm"),
    ]
    fixed = {("table", "stand"), ("table", "fence"), ("stand", "fence")}
    assert pairs(robot_with(joints, root="table")) == fixed | {("stand", "arm")}
    assert pairs(robot_with(joints, root="table"), "stand") == {("table", "fence"), ("table", "arm")}
    floating = fixed | {(name, "arm") for name in ("table", "stand", "fence")}
    assert pairs(robot_with(joints, root="table", fixed=False)) == floating


def test_the_order_of_joints_does_not_matter():
    joints = [joint("revolute", "base", name) for name in ("one", "two", "three")]
    joints += [joint("fixed", "one", "four"), joint("revolute", "two", "five"), joint("ball", "five", "six")]
    loops = [
        loop("ball", "six", "four", np.eye(4), np.eye(4)),
        loop("ball", "three", "six", np.eye(4), np.eye(4), name="second"),
    ]
    robot = robot_with(joints, loops=loops)
    order = [2, 1, 0, 4, 3, 5]
    links = (robot.links[0], *(robot.links[1 + index] for index in order))
    other = replace(robot, joints=tuple(robot.joints[i] for i in order), links=links, loops=robot.loops[::-1])
    for without in ("five", "two", "one", "three"):
        assert {frozenset(p) for p in pairs(other, without)} == {frozenset(p) for p in pairs(robot, without)}


def test_a_link_in_a_loop_of_links_without_colliders_is_not_next_to_itself():
    """As many pairs as neighbours, however they are reached."""
    ring = [loop("revolute", "c", "a", np.eye(4), np.eye(4))]
    robot = robot_with([joint("revolute", *pair) for pair in pairwise("abc")], root="a", loops=ring)
    assert pairs(robot, "b", "c") == set()
