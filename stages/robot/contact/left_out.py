"""Finds the links that MuJoCo never lets collide."""

from linkwright.stages.robot.model.robot import Robot

_WORLD = ""
"""The body of all that is fixed to the world, as MuJoCo's filter sees it."""


class FilteredPairs:
    """The pairs of links that MuJoCo never lets collide. They are on the same rigid body, or on a rigid body
    and its parent, unless that is the world (its documentation, "Computation", on collisions). A loop's
    carrier has no geoms and no child links."""

    def __init__(self, robot: Robot, parents: bool = True) -> None:
        """`parents`: whether it leaves out a body and its parent (flag `filterparent`)."""
        self._parents = parents
        root = robot.root.name
        self._body = {root: _WORLD if robot.base.fixed else root}
        self._above = {root: _WORLD, _WORLD: _WORLD}
        for joint in robot.joints:
            parent = self._body[joint.parent]
            self._body[joint.child] = joint.child if joint.dofs else parent
            if joint.dofs:
                self._above[joint.child] = _WORLD if joint.type == "free" else parent

    def contains(self, link: str, other_link: str) -> bool:
        """Returns whether MuJoCo leaves out this pair by itself."""
        a, b = self._body[link], self._body[other_link]
        if not self._parents:
            return a == b
        return a == b or (_WORLD not in (a, b) and (self._above[a] == b or self._above[b] == a))
