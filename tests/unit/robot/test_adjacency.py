"""Which links are next to each other, and the smallest trees that connect them, against networkx."""

from dataclasses import replace

import networkx as nx
import numpy as np
import pytest

from linkwright.stages.robot.model.robot import MeshRef
from linkwright.stages.robot.motion.adjacency import adjacent_pairs
from linkwright.stages.robot.motion.tree_paths import TreePaths
from tests.support.robots import EVERY, LOOPS, joint, loop, robot_with

HELD = tuple(kind for kind in EVERY if kind != "free")


def pairs(robot, without=""):
    """The pairs as "a b", of the links but these."""
    names = {link.name for link in robot.links} - set(without.split())
    return {" ".join(pair) for pair in adjacent_pairs(robot, names)}


def tree(*rows, **more):
    """A robot of joints "parent child kind", by default hinges."""
    joints = [joint(kind or "revolute", a, b) for a, b, kind in ((*row.split(), None)[:3] for row in rows)]
    return robot_with(joints, **{"root": rows[0].split()[0], **more})


def ends(kind, first, other, name="loop"):
    return loop(kind, first, other, np.eye(4), np.eye(4), name=name)


@pytest.mark.parametrize("kind", HELD)
@pytest.mark.parametrize("fixed", [True, False])
def test_links_joined_by_a_joint_are_adjacent(kind, fixed):
    robot = tree(f"base one {kind}", "one two", fixed=fixed)
    assert pairs(robot) == {"base one", "one two", *(["base two"] if kind == "fixed" and not fixed else [])}


@pytest.mark.parametrize("kind", LOOPS)
def test_links_joined_by_a_loop_are_adjacent(kind):
    robot = tree("base one", "base two", loops=[ends(kind, "two", "one")])
    assert pairs(robot) == {"base one", "base two", "one two"}


CRANKS = ("base crank", "base rocker", "crank rod")
ARM = ("base arm", "arm cover fixed", "cover hand", "hand pad fixed")
RIGID = {"arm cover", "hand pad", "arm hand", "arm pad", "cover hand", "cover pad"}
CELL = ("table stand fixed", "table fence fixed", "stand arm")
HELD_STILL = {"table stand", "table fence", "stand fence"}


@pytest.mark.parametrize(
    ("robot", "without", "expected"),
    [
        (tree("world one free", "one two ball"), "", {"one two"}),
        (tree("a b", "b c", "c d"), "b", {"a c", "c d"}),
        (tree("a b", "b c", "c d"), "b c", {"a d"}),
        (tree("b a", "b c"), "b", {"a c"}),
        (tree("wrist hand", "hand l prismatic", "hand r prismatic"), "hand", {"wrist l", "wrist r"}),
        (tree(*CRANKS, loops=[ends("revolute", "rod", "rocker")]), "rod",
         {"base crank", "base rocker", "crank rocker"}),
        # As many pairs as neighbours, however they are reached.
        (tree("a b", "b c", loops=[ends("revolute", "c", "a")]), "b c", set()),
        (tree(*ARM), "", RIGID | {"base arm", "base cover"}),
        (tree(*CELL), "", HELD_STILL | {"stand arm"}),
        (tree(*CELL), "stand", {"table fence", "table arm"}),
        (tree(*CELL, fixed=False), "", HELD_STILL | {"table arm", "stand arm", "fence arm"}),
    ],
    ids=["free", "passed through", "two passed through", "either end", "fingers", "a loop without a collider",
         "not next to itself", "rigid links", "workplace", "its stand passed through", "afloat"],
)  # fmt: skip
def test_links_without_a_collider_are_passed_through(robot, without, expected):
    assert pairs(robot, without) == expected


def test_rigid_body_collides_where_one_of_its_links_does():
    """So neither of two legs is next to the other."""
    assert "base hand" not in pairs(tree(*ARM), "arm")


def test_single_link_that_is_only_seen_is_passed_through():
    robot = tree("trunk upper", "upper fore", "fore hand")

    def seen(names):
        parts = {link.name: replace(link.parts[0], mesh=MeshRef("r", "p")) for link in robot.links}
        links = (replace(ln, parts=(parts[ln.name],)) if ln.name in names else ln for ln in robot.links)
        return replace(robot, links=tuple(links))

    assert pairs(seen(["upper"]), "upper fore") == {"trunk hand"}
    assert pairs(seen(["upper", "fore"]), "upper fore") == set()
    assert pairs(seen(["upper", "fore"]), "fore") == {"trunk upper", "upper hand"}


def test_order_of_joints_does_not_matter():
    loops = [ends("ball", "six", "four"), ends("ball", "three", "six", "second")]
    rows = ("base one", "base two", "base three", "one four fixed", "two five", "five six ball")
    robot = tree(*rows, loops=loops)
    order = [2, 1, 0, 4, 3, 5]
    links = (robot.links[0], *(robot.links[1 + index] for index in order))
    other = replace(robot, joints=tuple(robot.joints[i] for i in order), links=links, loops=robot.loops[::-1])
    for name in ("five", "two", "one", "three"):
        ours, theirs = ({frozenset(pair.split()) for pair in pairs(r, name)} for r in (robot, other))
        assert ours == theirs


def random_tree(seed):
    """Thirty links, each on any of those before it, by hinges."""
    random = np.random.default_rng(seed)
    rows = [joint("revolute", f"l{random.integers(i)}", f"l{i}") for i in range(1, 30)]
    robot = robot_with(rows, root="l0")
    return robot, nx.DiGraph((joint.parent, joint.child) for joint in robot.joints)


@pytest.mark.parametrize("seed", range(20))
def test_tree_of_links_is_the_smallest_that_connects_them(seed):
    robot, graph = random_tree(seed)
    names = [link.name for link in robot.links]
    chosen = np.random.default_rng(seed).choice(names, size=1 + seed % 5, replace=False).tolist()
    top, joints = TreePaths(robot).tree_of(chosen)
    meeting = chosen[0]
    for link in chosen[1:]:
        meeting = nx.lowest_common_ancestor(graph, meeting, link)
    between = {edge for link in chosen for edge in nx.utils.pairwise(nx.shortest_path(graph, meeting, link))}
    assert top == meeting
    assert {(joint.parent, joint.child) for joint in joints} == between
    reached = [top, *(joint.child for joint in joints)]
    assert all(joint.parent in reached[: number + 1] for number, joint in enumerate(joints))
    for link in names:
        way = nx.shortest_path(graph, robot.root.name, link)
        assert [joint.child for joint in TreePaths(robot).up(link)] == way[:0:-1]
