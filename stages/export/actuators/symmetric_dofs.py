"""Joints that are copies of each other, as those of a left and a right leg: one estimate holds for them all.

Loads are found at some poses of the range, which are not each other's mirror images; two knees would get two
stiffnesses for no reason that anybody could see.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from linkwright.stages.export.actuators.loads import Load
from linkwright.stages.robot.model.robot import Dof, Joint, Robot

MASS = 0.01
"""Copies move masses that differ by at most this share: left and right parts of CAD are rarely equal."""

SAMPLED = 1.5
"""The loads of copies, found at poses of which none are the same, differ by at most this factor."""


@dataclass(frozen=True, slots=True)
class _Copy:
    """What a dof is known by: its `place` is its number of joints from the root and its own in its joint."""

    dof: Dof
    place: tuple[int, int]
    mass: float
    load: Load

    def is_of(self, other: "_Copy") -> bool:
        one, two = self.dof, other.dof
        return (
            one.kind == two.kind
            and self.place == other.place
            and one.dynamics == two.dynamics
            and math.isclose(_width(one), _width(two), rel_tol=1e-6)
            and math.isclose(self.mass, other.mass, rel_tol=MASS)
            and _near(self.load.most, other.load.most)
            and _near(self.load.most_inertia, other.load.most_inertia)
        )


def shared(robot: Robot, found: Mapping[str, Load]) -> dict[str, Load]:
    """The loads, those of copies with the largest `most` and `most_inertia` of them all."""
    groups: list[list[_Copy]] = []
    for one in _copies(robot, found):
        same = next((group for group in groups if one.is_of(group[0])), None)
        if same is None:
            groups.append([one])
        else:
            same.append(one)
    return {
        one.dof.name: replace(
            one.load,
            most=max(other.load.most for other in group),
            most_inertia=max(other.load.most_inertia for other in group),
        )
        for group in groups
        for one in group
    }


def _copies(robot: Robot, found: Mapping[str, Load]) -> Iterator[_Copy]:
    depths: dict[str, int] = {robot.root.name: 0}
    for joint in robot.joints:
        depths[joint.child] = depths[joint.parent] + 1
    masses = _moved(robot.joints, {link.name: link.inertial.mass for link in robot.links})
    for joint in robot.joints:
        for number, dof in enumerate(joint.dofs):
            if dof.name in found:
                yield _Copy(dof, (depths[joint.child], number), masses[joint.child], found[dof.name])


def _moved(joints: tuple[Joint, ...], masses: dict[str, float]) -> dict[str, float]:
    """By link: the mass [kg] of it and of all below it."""
    for joint in reversed(joints):
        masses[joint.parent] += masses[joint.child]
    return masses


def _width(dof: Dof) -> float:
    low, high = dof.limits.interval
    return high - low


def _near(one: float, other: float) -> bool:
    return max(one, other) <= SAMPLED * min(one, other)
