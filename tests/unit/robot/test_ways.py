"""Ways up the tree, against networkx on random trees."""

import networkx as nx
import numpy as np
import pytest

from linkwright.stages.graph import build_robot
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.tree_paths import Ways
from tests.support.building import plan_of
from tests.support.urdfs import urdf_bundle

INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def random_tree(seed: int) -> Robot:
    """Thirty links, each on any of those before it, by hinges."""
    random = np.random.default_rng(seed)
    links = "".join(f'<link name="l{i}">{INERTIAL}</link>' for i in range(30))
    joints = "".join(
        f'<joint name="j{i}" type="continuous"><parent link="l{random.integers(i)}"/><child link="l{i}"/>'
        "</joint>"
        for i in range(1, 30)
    )
    return build_robot(urdf_bundle(f'<robot name="r">{links}{joints}</robot>'.encode()), plan_of())


@pytest.mark.parametrize("seed", range(20))
def test_the_tree_of_some_links_is_the_smallest_that_connects_them(seed: int) -> None:
    robot = random_tree(seed)
    graph = nx.DiGraph((joint.parent, joint.child) for joint in robot.joints)
    names = [link.name for link in robot.links]
    chosen = np.random.default_rng(seed).choice(names, size=1 + seed % 5, replace=False).tolist()
    top, joints = Ways(robot).tree_of(chosen)
    meeting = chosen[0]
    for link in chosen[1:]:
        meeting = nx.lowest_common_ancestor(graph, meeting, link)
    between = {edge for link in chosen for edge in nx.utils.pairwise(nx.shortest_path(graph, meeting, link))}
    assert top == meeting
    assert {(joint.parent, joint.child) for joint in joints} == between
    reached = [top, *(joint.child for joint in joints)]
    assert all(joint.parent in reached[: number + 1] for number, joint in enumerate(joints))


@pytest.mark.parametrize("seed", range(20))
def test_the_way_up_ends_at_the_root(seed: int) -> None:
    robot = random_tree(seed)
    graph = nx.DiGraph((joint.parent, joint.child) for joint in robot.joints)
    for link in robot.links:
        way = nx.shortest_path(graph, robot.root.name, link.name)
        assert [joint.child for joint in Ways(robot).up(link.name)] == way[:0:-1]
