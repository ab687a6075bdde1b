"""Finds the pairs of links that MuJoCo never lets collide."""

from linkwright.stages.robot.model.robot import Robot

_WORLD = ""
"""Name of the rigid body of all links that are fixed to the world: MuJoCo treats them as its body 0."""


class FilteredPairs:
    """The pairs of links that MuJoCo never lets collide: links on the same rigid body, or on a rigid body and
    its parent, unless the parent is the world (MuJoCo's documentation, "Computation", on collisions). The
    bodies that MuJoCo needs for loops do not count: they have no geoms and no child links."""

    def __init__(self, robot: Robot, filters_parents: bool = True) -> None:
        """`filters_parents`: whether a body and its parent are a pair (MuJoCo's flag `filterparent`)."""
        self._filters_parents = filters_parents
        root = robot.root.name
        # A rigid body is named by its first link.
        self._body_of = {root: _WORLD if robot.base.fixed else root}
        self._parent_of = {root: _WORLD, _WORLD: _WORLD}
        for joint in robot.joints:
            parent = self._body_of[joint.parent]
            self._body_of[joint.child] = joint.child if joint.dofs else parent
            if joint.dofs:
                self._parent_of[joint.child] = _WORLD if joint.type == "free" else parent

    def contains(self, link: str, other_link: str) -> bool:
        """Returns whether MuJoCo never lets these two links collide."""
        body, other_body = self._body_of[link], self._body_of[other_link]
        if body == other_body:
            return True
        if not self._filters_parents or _WORLD in (body, other_body):
            return False
        return self._parent_of[body] == other_body or self._parent_of[other_body] == body
