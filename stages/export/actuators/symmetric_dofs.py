"""Gives joints that are copies of each other, such as those of a left and a right leg, the same load.

Loads are computed at sampled poses, which are not mirror images of each other. Without this step, two equal
knees would get different stiffnesses.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from linkwright.stages.export.actuators.loads import Load
from linkwright.stages.robot.model.robot import Dof, Joint, Robot

MASS_TOLERANCE = 0.01
"""Largest relative difference of the masses that copies move: left and right parts of CAD are rarely
equal."""

MAX_LOAD_RATIO = 1.5
"""Largest ratio of the loads of copies, which are sampled at different poses."""


@dataclass(frozen=True, slots=True)
class _Copy:
    """A dof with the properties by which copies are recognized."""

    dof: Dof

    place: tuple[int, int]
    """The number of joints between the root and the dof, and the index of the dof in its joint."""

    mass: float
    """The mass [kg] that the dof moves."""

    load: Load

    def is_copy_of(self, other: "_Copy") -> bool:
        """Returns whether both dofs have the same place, kind, dynamics and range, and similar masses and
        loads."""
        first, second = self.dof, other.dof
        return (
            first.kind == second.kind
            and self.place == other.place
            and first.dynamics == second.dynamics
            and math.isclose(_width(first), _width(second), rel_tol=1e-6)
            and math.isclose(self.mass, other.mass, rel_tol=MASS_TOLERANCE)
            and _are_similar(self.load.largest_force, other.load.largest_force)
            and _are_similar(self.load.largest_inertia, other.load.largest_inertia)
        )


def share_loads(robot: Robot, loads: Mapping[str, Load]) -> dict[str, Load]:
    """Returns the loads, where each copy has the largest `largest_force` and `largest_inertia` among its
    copies."""
    groups: list[list[_Copy]] = []
    for copy in _dofs_with_loads(robot, loads):
        group = next((group for group in groups if copy.is_copy_of(group[0])), None)
        if group is None:
            groups.append([copy])
        else:
            group.append(copy)
    return {
        copy.dof.name: replace(
            copy.load,
            largest_force=max(other.load.largest_force for other in group),
            largest_inertia=max(other.load.largest_inertia for other in group),
        )
        for group in groups
        for copy in group
    }


def _dofs_with_loads(robot: Robot, loads: Mapping[str, Load]) -> Iterator[_Copy]:
    depths: dict[str, int] = {robot.root.name: 0}
    for joint in robot.joints:
        depths[joint.child] = depths[joint.parent] + 1
    masses = _subtree_masses(robot.joints, {link.name: link.inertial.mass for link in robot.links})
    for joint in robot.joints:
        for index, dof in enumerate(joint.dofs):
            if dof.name in loads:
                yield _Copy(dof, (depths[joint.child], index), masses[joint.child], loads[dof.name])


def _subtree_masses(joints: tuple[Joint, ...], masses: dict[str, float]) -> dict[str, float]:
    """Returns, by link, the mass [kg] of it and of all links below it: `masses` itself, with sums in place of
    the links' own masses."""
    for joint in reversed(joints):
        masses[joint.parent] += masses[joint.child]
    return masses


def _width(dof: Dof) -> float:
    """Returns the width [rad or m] of a dof's range; infinite without a limit."""
    low, high = dof.limits.interval
    return high - low


def _are_similar(first: float, second: float) -> bool:
    return max(first, second) <= MAX_LOAD_RATIO * min(first, second)
