"""Finds paths in the tree of a robot, from links up to the root or to the link where they meet."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TypeVar

from linkwright.stages.robot.model.robot import Dof, Joint, Loop, Robot

Node = TypeVar("Node")


def paths_up(
    first: Node, second: Node, parents: Mapping[Node, Node], order: Mapping[Node, int]
) -> tuple[list[Node], list[Node]]:
    """Returns the two paths from nodes up to the node where they meet, without this node. `order`: the place
    of each node in an order in which parents come before their children."""
    paths: tuple[list[Node], list[Node]] = ([], [])
    ends = [first, second]
    while ends[0] != ends[1]:
        # The later node is not above the other, so its path goes up.
        later = int(order[ends[1]] > order[ends[0]])
        paths[later].append(ends[later])
        ends[later] = parents[ends[later]]
    return paths


class TreePaths:
    """The joints on the paths up from a robot's links. Finding a path takes time in proportion to its
    length."""

    def __init__(self, robot: Robot) -> None:
        self._joint_above = {joint.child: joint for joint in robot.joints}
        self._parents = {joint.child: joint.parent for joint in robot.joints}
        self._order = {link.name: number for number, link in enumerate(robot.links)}

    def up(self, link: str) -> Iterator[Joint]:
        """Yields the joints from a link up to the root."""
        while link in self._joint_above:
            joint = self._joint_above[link]
            yield joint
            link = joint.parent

    def of_loop(self, loop: Loop) -> tuple[list[Joint], list[Joint]]:
        """Returns the joints on the paths from `link_a` and from `link_b` of a loop up to the link where both
        meet."""
        to_a, to_b = paths_up(loop.link_a, loop.link_b, self._parents, self._order)
        return [self._joint_above[link] for link in to_a], [self._joint_above[link] for link in to_b]

    def dofs_of(self, loop: Loop) -> list[Dof]:
        """Returns the dofs that move the frames of a loop against each other: those on its paths, then its
        own."""
        path_dofs = [dof for path in self.of_loop(loop) for joint in path for dof in joint.dofs]
        return [*path_dofs, *loop.dofs]

    def tree_of(self, links: Iterable[str]) -> tuple[str, list[Joint]]:
        """Returns the link where the paths up from these links meet, and the joints on the paths, parents
        first. `links` must not be empty."""
        climbed: set[str] = set()
        top: str | None = None
        for link in links:
            if top is None:
                top = link
            # A path ends where it meets another, so that each link is climbed from once.
            while link != top and link not in climbed:
                if self._order[link] > self._order[top]:
                    climbed.add(link)
                    link = self._parents[link]
                else:
                    climbed.add(top)
                    top = self._parents[top]
        assert top is not None
        return top, [self._joint_above[link] for link in sorted(climbed, key=self._order.__getitem__)]
