"""Ways along the tree of a robot: from links up to the root, or to where they meet."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TypeVar

from linkwright.stages.robot.model.robot import Dof, Joint, Loop, Robot

Node = TypeVar("Node")


def ways_up(
    first: Node, second: Node, parents: Mapping[Node, Node], order: Mapping[Node, int]
) -> tuple[list[Node], list[Node]]:
    """The two ways up a tree to where they meet, without that, each from its start; `order` has a parent
    before its children."""
    ways: tuple[list[Node], list[Node]] = ([], [])
    ends = [first, second]
    while ends[0] != ends[1]:
        # The later of the two is above neither.
        later = int(order[ends[1]] > order[ends[0]])
        ways[later].append(ends[later])
        ends[later] = parents[ends[later]]
    return ways


class Ways:
    """The joints on the ways up from a robot's links. A way costs as much as it is long."""

    def __init__(self, robot: Robot) -> None:
        self._above = {joint.child: joint for joint in robot.joints}
        self._parents = {joint.child: joint.parent for joint in robot.joints}
        self._order = {link.name: number for number, link in enumerate(robot.links)}

    def up(self, link: str) -> Iterator[Joint]:
        """The joints from a link up to the root."""
        while link in self._above:
            joint = self._above[link]
            yield joint
            link = joint.parent

    def of_loop(self, loop: Loop) -> tuple[list[Joint], list[Joint]]:
        """The joints from both links of a loop up to where these ways meet."""
        to_a, to_b = ways_up(loop.link_a, loop.link_b, self._parents, self._order)
        return [self._above[link] for link in to_a], [self._above[link] for link in to_b]

    def dofs_of(self, loop: Loop) -> list[Dof]:
        """The dofs by which a loop's frames move against each other: those on its ways, and its own."""
        on_ways = [dof for way in self.of_loop(loop) for joint in way for dof in joint.dofs]
        return [*on_ways, *loop.dofs]

    def tree_of(self, links: Iterable[str]) -> tuple[str, list[Joint]]:
        """The link where the ways up from the links meet, and the joints on these, parents first."""
        found: set[str] = set()
        top: str | None = None
        for link in links:
            if top is None:
                top = link
            # No link is climbed from twice: the rest of a way that meets another is known.
            while link != top and link not in found:
                if self._order[link] > self._order[top]:
                    found.add(link)
                    link = self._parents[link]
                else:
                    found.add(top)
                    top = self._parents[top]
        assert top is not None
        return top, [self._above[link] for link in sorted(found, key=self._order.__getitem__)]
