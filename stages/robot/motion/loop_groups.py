"""Groups loops that move together, and makes a robot of each group."""

from dataclasses import replace

import networkx as nx

from linkwright.stages.robot.model.robot import Loop, Relation, Robot
from linkwright.stages.robot.motion.tree_paths import TreePaths


class LoopGroups:
    """The loops of a robot in groups: loops of two groups do not share a dof, also not through relations."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._paths = TreePaths(robot)
        self._links = {link.name: link for link in robot.links}
        self._ends_of_dof = {
            dof.name: (joint.parent, joint.child) for joint in robot.joints for dof in joint.dofs
        }
        self._drivers = {relation.follower: relation.driver for relation in robot.relations}
        self._relations_by_driver: dict[str, list[Relation]] = {}
        for relation in robot.relations:
            self._relations_by_driver.setdefault(relation.driver, []).append(relation)

    def mechanisms(self) -> list[Robot]:
        """Returns for each group the part of the robot that its loops and relations need, as a robot whose
        root is the link where the paths up from its links meet. The cost depends on the size of the group
        alone."""
        forest = nx.utils.UnionFind(range(len(self._robot.loops)))
        first_loops: dict[str, int] = {}
        for index, loop in enumerate(self._robot.loops):
            for name in self.dofs_of(loop):
                forest.union(index, first_loops.setdefault(name, index))
        groups: dict[int, list[Loop]] = {}
        for index, loop in enumerate(self._robot.loops):
            groups.setdefault(forest[index], []).append(loop)
        return [self._mechanism(loops) for loops in groups.values()]

    def dofs_of(self, loop: Loop) -> set[str]:
        """Returns the dofs on which a loop depends, including its own; a driver takes the place of its
        followers."""
        moving = (dof.name for dof in self._paths.dofs_of(loop) if dof.kind != "free")
        return {self._drivers.get(name, name) for name in moving}

    def _mechanism(self, loops: list[Loop]) -> Robot:
        dofs = {name for loop in loops for name in self.dofs_of(loop)}
        relations = [
            relation for name in sorted(dofs) for relation in self._relations_by_driver.get(name, ())
        ]
        coupled_dofs = dofs | {relation.follower for relation in relations}
        ends = {end for loop in loops for end in (loop.link_a, loop.link_b)}
        # The links of the dofs too: a driver may be above the paths of all loops.
        ends |= {end for name in coupled_dofs for end in self._ends_of_dof.get(name, ())}
        top, joints = self._paths.tree_of(sorted(ends))
        names = [top, *(joint.child for joint in joints)]
        return replace(
            self._robot,
            links=tuple(self._links[name] for name in names),
            joints=tuple(joints),
            loops=tuple(loops),
            relations=tuple(relations),
            frames=(),
        )
