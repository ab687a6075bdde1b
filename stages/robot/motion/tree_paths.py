"""Finds paths along the tree of a robot: from links up to the root, or to where they meet."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TypeVar

from linkwright.stages.robot.model.robot import Dof, Joint, Loop, Robot

Node = TypeVar("Node")


def paths_up(
    first: Node, second: Node, parents: Mapping[Node, Node], order: Mapping[Node, int]
) -> tuple[list[Node], list[Node]]:
    """Returns the two paths up a tree to where they meet, without that node, each from its start; `order` has
    a parent before its children."""
    paths: tuple[list[Node], list[Node]] = ([], [])
    ends = [first, second]
    while ends[0] != ends[1]:
        # The later of the two is above neither end.
        later = int(order[ends[1]] > order[ends[0]])
        paths[later].append(ends[later])
        ends[later] = parents[ends[later]]
    return paths


class TreePaths:
    """The joints on the paths up from a robot's links. The cost of a path is its length."""

    def __init__(self, robot: Robot) -> None:
        self._above = {joint.child: joint for joint in robot.joints}
        self._parents = {joint.child: joint.parent for joint in robot.joints}
        self._order = {link.name: number for number, link in enumerate(robot.links)}

    def up(self, link: str) -> Iterator[Joint]:
        """Yields the joints from a link up to the root."""
        while link in self._above:
            joint = self._above[link]
            yield joint
            link = joint.parent

    def of_loop(self, loop: Loop) -> tuple[list[Joint], list[Joint]]:
        """Returns the joints from both links of a loop up to where these paths meet."""
        to_a, to_b = paths_up(loop.link_a, loop.link_b, self._parents, self._order)
        return [self._above[link] for link in to_a], [self._above[link] for link in to_b]

    def dofs_of(self, loop: Loop) -> list[Dof]:
        """Returns the dofs by which a loop's frames move against each other: those on its paths, and its
        own."""
        path_dofs = [dof for path in self.of_loop(loop) for joint in path for dof in joint.dofs]
        return [*path_dofs, *loop.dofs]

    def tree_of(self, links: Iterable[str]) -> tuple[str, list[Joint]]:
        """Returns the link where the paths up from the links meet, and the joints on these, parents first."""
        climbed: set[str] = set()
        top: str | None = None
        for link in links:
            if top is None:
                top = link
            # No link is climbed from twice: a path ends where it meets another.
            while link != top and link not in climbed:
                if self._order[link] > self._order[top]:
                    climbed.add(link)
                    link = self._parents[link]
                else:
                    climbed.add(top)
                    top = self._parents[top]
        assert top is not None
        return top, [self._above[link] for link in sorted(climbed, key=self._order.__getitem__)]
