"""Loop closures in MJCF: sites on both links, equalities between the sites, and carriers.

A hinge is closed by two points on its axis, a ball by one point, a rigid mate by a weld. Any other mate
gets a carrier: a body on one link that moves by the mate's own dofs and is welded to the other link, of
whose mass it has a share. MuJoCo scales a constraint by the inverse inertia of the bodies that it
constrains, so a carrier of almost no mass would leave the weld slack; with equal shares both bodies are
stiff, and they move together as the whole link.

That scale is a mean over all directions, which overestimates the compliance in the constrained ones: with
MuJoCo's default impedance an equality yields to a tenth of the load, so all get the highest impedance.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.export.mjcf.placement import placement
from linkwright.stages.formats.numbers import spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.dynamics.inertia import moved
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Inertial, Loop, Robot, frozen
from linkwright.stages.robot.motion.kinematics import chain
from linkwright.stages.robot.motion.loops import POINTWISE
from linkwright.stages.robot.text.names import free

Site = tuple[str, str, Array]
"""The link (or carrier) that has the site, the site's name, and its pose (4, 4) on the link."""

POINTS = {"revolute": ("", "_axis"), "ball": ("",)}
"""Types of loops that points close → the endings of the equalities' names."""

STIFF = "0.9999 0.9999 0.001"
"""`solimp`: the impedance that MuJoCo allows at most, whatever the violation."""


@dataclass(frozen=True, slots=True, eq=False)
class Carrier:
    """A body below `parent` that moves by `dofs`, welded to the link `carried`, of which it has a share.

    The carrier's frame is the loop's frame on `carried`.
    """

    name: str
    loop: Loop
    parent: str
    parent_from_joint: Array
    dofs: tuple[Dof, ...]
    carried: str
    carried_from_carrier: Array

    def pose(self, start: Configuration) -> Array:
        """parent_from_carrier (4, 4) at the values `start`."""
        return self.parent_from_joint @ chain(self.dofs, start)


class Closures:
    """The sites, carriers and equalities of a robot's loops; every name is unique in its kind."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.carriers = tuple(_carriers(robot))
        self._carrier_of = {carrier.loop.name: carrier for carrier in self.carriers}
        taken = {frame.name for frame in robot.frames}
        self._inertials = {link.name: link.inertial for link in robot.links}
        self._carried = Counter(carrier.carried for carrier in self.carriers)
        self._sites: dict[str, tuple[Site, ...]] = {}
        self._sites_on: dict[str, list[Site]] = {}
        for loop in robot.loops:
            named: list[Site] = []
            for link, suffix, pose in self._ends(loop):
                named.append((link, free(f"{loop.name}_{suffix}", taken), pose))
                taken.add(named[-1][1])
                self._sites_on.setdefault(link, []).append(named[-1])
            self._sites[loop.name] = tuple(named)

    def _ends(self, loop: Loop) -> Iterator[Site]:
        """The sites of a loop: both of the first pair, then both of the second."""
        carrier = self._carrier_of.get(loop.name)
        if carrier is not None:
            yield carrier.carried, "a", carrier.carried_from_carrier
            yield carrier.name, "b", np.eye(4)
            return
        yield loop.link_a, "a", loop.a_from_frame
        yield loop.link_b, "b", loop.b_from_frame
        if loop.type == "revolute":
            yield loop.link_a, "a_axis", _along_axis(loop.a_from_frame, loop)
            yield loop.link_b, "b_axis", _along_axis(loop.b_from_frame, loop)

    def write_sites(self, body: Element, link: str, body_from_link: Array) -> None:
        """The sites on a link, or carrier, under its element."""
        for _, name, pose in self._sites_on.get(link, ()):
            element(body, "site", name=name, **placement(body_from_link @ pose))

    def share(self, link: str, inertial: Inertial) -> Inertial:
        """The share of a link's inertial that its own body has, and each of its carriers."""
        count = 1 + self._carried[link]
        if count == 1:
            return inertial
        return replace(inertial, mass=inertial.mass / count, inertia=frozen(inertial.inertia / count))

    def carries(self, carrier: Carrier) -> Inertial:
        """A carrier's share, in its own frame."""
        whole = self._inertials[carrier.carried]
        return moved(self.share(carrier.carried, whole), inverse(carrier.carried_from_carrier))

    def write_equalities(
        self, equality: Element, timestep: float, extras: Mapping[str, Mapping[str, str]]
    ) -> None:
        """Two points meet in a `connect`, two frames in a `weld`. `extras`: by loop, what an MJCF source says
        of its stiffness."""
        taken = {loop.name for loop in self._robot.loops}
        taken |= {relation.name for relation in self._robot.relations}
        for loop in self._robot.loops:
            names = [name for _, name, _ in self._sites[loop.name]]
            kind = "connect" if loop.type in POINTS else "weld"
            for index, suffix in enumerate(POINTS.get(loop.type, ("",))):
                name = free(loop.name + suffix, taken) if suffix else loop.name
                taken.add(name)
                one, other = names[2 * index : 2 * index + 2]
                stiff = {"solref": spaced(held(loop.solref, timestep)), "solimp": STIFF}
                stiff = {**extras.get(loop.name, stiff)}
                element(equality, kind, name=name, site1=one, site2=other, **stiff)


def held(solref: tuple[float, float], timestep: float) -> tuple[float, float]:
    """The time constant and damping ratio that a time step [s] can hold: no constraint is stiffer than two
    steps (MuJoCo's documentation, "Solver parameters"). A stiffness and damping stay as they are."""
    return (max(solref[0], 2.0 * timestep), solref[1]) if solref[0] > 0 else solref


def _carriers(robot: Robot) -> Iterator[Carrier]:
    taken, moving = {link.name for link in robot.links}, _moving(robot)
    for loop in robot.loops:
        if loop.type in POINTWISE:
            continue
        name = free(f"{loop.name}_carrier", taken)
        taken.add(name)
        if loop.link_a in moving:
            place, dofs = loop.b_from_frame, loop.dofs
            yield Carrier(name, loop, loop.link_b, place, dofs, loop.link_a, loop.a_from_frame)
        else:
            # A fixed link may have no mass to share: the other link is carried, by the reversed chain.
            dofs = _reversed(loop.dofs)
            yield Carrier(name, loop, loop.link_a, loop.a_from_frame, dofs, loop.link_b, loop.b_from_frame)


def _moving(robot: Robot) -> set[str]:
    """The links that can move against the world."""
    if not robot.base.fixed:
        return {link.name for link in robot.links}
    moving: set[str] = set()
    for joint in robot.joints:
        if joint.dofs or joint.parent in moving:
            moving.add(joint.child)
    return moving


def _reversed(dofs: tuple[Dof, ...]) -> tuple[Dof, ...]:
    """The chain in the opposite direction: (Π O M)⁻¹ as a chain of dofs."""
    origins = [frozen(np.eye(4)), *(frozen(inverse(dof.origin)) for dof in dofs[:0:-1])]
    return tuple(
        replace(dof, axis=frozen(-dof.axis), origin=origin)
        for dof, origin in zip(reversed(dofs), origins, strict=True)
    )


def _along_axis(pose: Array, loop: Loop) -> Array:
    shifted = np.array(pose)
    (dof,) = loop.dofs
    # The mate's own axis: the direction in which the user counts must not move the point.
    shifted[:3, 3] += pose[:3, :3] @ dof.axis * dof.in_mate.sign * loop.lever
    return shifted
