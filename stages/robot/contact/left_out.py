"""Which links MuJoCo never lets collide."""

from linkwright.stages.robot.model.robot import Robot

_WORLD = ""
"""The body of all that is fixed to the world, as MuJoCo's filter sees it."""


class LeftOut:
    """The pairs of links that MuJoCo never lets collide: those on one rigid body, and a rigid body and the
    one that it hangs on, unless that is the world (its documentation, "Computation", on collisions).

    A loop's carrier has no geoms, and no link hangs on it.
    """

    def __init__(self, robot: Robot, parents: bool = True) -> None:
        """`parents`: whether it leaves out a body and the one that it hangs on (flag `filterparent`)."""
        self._parents = parents
        root = robot.root.name
        self._body = {root: _WORLD if robot.base.fixed else root}
        self._above = {root: _WORLD, _WORLD: _WORLD}
        for joint in robot.joints:
            parent = self._body[joint.parent]
            self._body[joint.child] = joint.child if joint.dofs else parent
            if joint.dofs:
                self._above[joint.child] = _WORLD if joint.type == "free" else parent

    def contains(self, one: str, other: str) -> bool:
        """Whether MuJoCo leaves out this pair by itself."""
        a, b = self._body[one], self._body[other]
        if not self._parents:
            return a == b
        return a == b or (_WORLD not in (a, b) and (self._above[a] == b or self._above[b] == a))
