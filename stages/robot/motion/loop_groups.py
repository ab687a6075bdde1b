"""Groups loops that move together, each group as a mechanism of its own."""

from dataclasses import replace

import networkx as nx

from linkwright.stages.robot.model.robot import Loop, Relation, Robot
from linkwright.stages.robot.motion.tree_paths import TreePaths


class LoopGroups:
    """The loops of a robot in groups that share no dof, by themselves or through relations."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._ways = TreePaths(robot)
        self._links = {link.name: link for link in robot.links}
        self._around = {dof.name: (joint.parent, joint.child) for joint in robot.joints for dof in joint.dofs}
        self._drivers = {relation.follower: relation.driver for relation in robot.relations}
        self._driven: dict[str, list[Relation]] = {}
        for relation in robot.relations:
            self._driven.setdefault(relation.driver, []).append(relation)

    def mechanisms(self) -> list[Robot]:
        """Returns the part of the robot that each group's loops and relations need, as a robot: its root is
        the link where the paths to its links meet. The cost depends on the group alone."""
        forest = nx.utils.UnionFind(range(len(self._robot.loops)))
        first: dict[str, int] = {}
        for number, loop in enumerate(self._robot.loops):
            for name in self.moved_by(loop):
                forest.union(number, first.setdefault(name, number))
        groups: dict[int, list[Loop]] = {}
        for number, loop in enumerate(self._robot.loops):
            groups.setdefault(forest[number], []).append(loop)
        return [self._mechanism(loops) for loops in groups.values()]

    def moved_by(self, loop: Loop) -> set[str]:
        """Returns the dofs on which a loop depends, its own too, where drivers replace their followers."""
        moving = (dof.name for dof in self._ways.dofs_of(loop) if dof.kind != "free")
        return {self._drivers.get(name, name) for name in moving}

    def _mechanism(self, loops: list[Loop]) -> Robot:
        moved = {name for loop in loops for name in self.moved_by(loop)}
        relations = [relation for name in sorted(moved) for relation in self._driven.get(name, ())]
        tied = moved | {relation.follower for relation in relations}
        ends = {end for loop in loops for end in (loop.link_a, loop.link_b)}
        # The link above a joint too: a driver may be above all that it drives.
        ends |= {end for name in tied for end in self._around.get(name, ())}
        top, joints = self._ways.tree_of(sorted(ends))
        names = [top, *(joint.child for joint in joints)]
        return replace(
            self._robot,
            links=tuple(self._links[name] for name in names),
            joints=tuple(joints),
            loops=tuple(loops),
            relations=tuple(relations),
            frames=(),
        )
