"""Pairs of bodies that do not collide, in MJCF."""

from stages.formats.xml import Element, element
from stages.robot.geometry import Geometry
from stages.robot.model import Robot

_WORLD = ""
"""The body of all that is fixed to the world, as MuJoCo's filter sees it."""


def write_excludes(root: Element, robot: Robot, geometry: Geometry) -> None:
    """An `<exclude>` for each pair that MuJoCo does not leave out by itself."""
    left_out = LeftOut(robot)
    pairs = [(one.link_a, one.link_b) for one in geometry.excludes]
    pairs = [pair for pair in pairs if not left_out.contains(*pair)]
    if pairs:
        contact = element(root, "contact")
        for one, other in pairs:
            element(contact, "exclude", body1=one, body2=other)


class LeftOut:
    """The pairs of links that MuJoCo never lets collide: those on one rigid body, and a rigid body and the
    one that it hangs on, unless that is the world (its documentation, "Computation", on collisions).

    A loop's carrier has no geoms, and no link hangs on it.
    """

    def __init__(self, robot: Robot) -> None:
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
        return a == b or (_WORLD not in (a, b) and (self._above[a] == b or self._above[b] == a))
