"""Ways up the tree, against networkx on random trees."""

import networkx as nx
import numpy as np
import pytest

from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.tree_paths import TreePaths
from tests.support.robots import joint, robot_with


def random_tree(seed: int) -> tuple[Robot, nx.DiGraph]:
    """Thirty links, each on any of those before it, by hinges."""
    random = np.random.default_rng(seed)
    rows = [joint("revolute", f"l{random.integers(i)}", f"l{i}") for i in range(1, 30)]
    robot = robot_with(rows, root="l0")
    return robot, nx.DiGraph((joint.parent, joint.child) for joint in robot.joints)


@pytest.mark.parametrize("seed", range(20))
def test_the_tree_of_links_is_the_smallest_that_connects_them(seed):
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
