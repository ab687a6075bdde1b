"""Writes loop closures in MJCF: sites on both links, equalities between the sites, and carriers.

A hinge is closed by two points on its axis, a ball by one point, a rigid mate by a weld. Any other mate
gets a carrier: a body on one link that moves by the mate's own dofs, is welded to the other link, and has a
share of that link's mass. MuJoCo scales a constraint by the inverse inertia of the bodies that it
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
from linkwright.stages.robot.motion.loops import POINTWISE_TYPES
from linkwright.stages.robot.text.names import free_name

Site = tuple[str, str, Array]
"""(link or carrier that has the site, name of the site, its pose (4, 4) in the frame of that link or
carrier)."""

EQUALITY_SUFFIXES = {"revolute": ("", "_axis"), "ball": ("",)}
"""Type of loop that is closed by points → the endings of its equalities' names."""

MAX_IMPEDANCE = "0.9999 0.9999 0.001"
"""`solimp` with MuJoCo's largest impedance, whatever the violation."""


@dataclass(frozen=True, slots=True, eq=False)
class Carrier:
    """A body that is connected to a link by the dofs of a loop, is welded to another link, and has a share of
    that link's mass."""

    name: str

    loop: Loop

    parent: str
    """The link to which the carrier is connected by `dofs`."""

    parent_from_joint: Array
    """The frame (4, 4) of the first dof on the parent."""

    dofs: tuple[Dof, ...]

    carried: str
    """The link to which the carrier is welded."""

    carried_from_carrier: Array
    """The carrier's frame (4, 4) on the link `carried`: the loop's frame on that link."""

    def pose(self, start: Configuration) -> Array:
        """Returns parent_from_carrier (4, 4) at the values `start`."""
        return self.parent_from_joint @ chain(self.dofs, start)


class Closures:
    """The sites, carriers and equalities of a robot's loops. Names are unique among sites, among links and
    carriers, and among equalities."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.carriers = tuple(_carriers(robot))
        self._carrier_of = {carrier.loop.name: carrier for carrier in self.carriers}
        self._inertials = {link.name: link.inertial for link in robot.links}
        self._carrier_counts = Counter(carrier.carried for carrier in self.carriers)
        taken = {frame.name for frame in robot.frames}
        self._sites: dict[str, tuple[Site, ...]] = {}
        self._sites_on: dict[str, list[Site]] = {}
        for loop in robot.loops:
            sites: list[Site] = []
            for link, suffix, pose in self._ends(loop):
                sites.append((link, free_name(f"{loop.name}_{suffix}", taken), pose))
                taken.add(sites[-1][1])
                self._sites_on.setdefault(link, []).append(sites[-1])
            self._sites[loop.name] = tuple(sites)

    def _ends(self, loop: Loop) -> Iterator[Site]:
        """Yields the sites of a loop, each with the suffix of its name in place of the name: both sites of
        the first pair, then both of the second pair."""
        carrier = self._carrier_of.get(loop.name)
        if carrier is not None:
            yield carrier.carried, "a", carrier.carried_from_carrier
            yield carrier.name, "b", np.eye(4)
            return
        yield loop.link_a, "a", loop.a_from_frame
        yield loop.link_b, "b", loop.b_from_frame
        if loop.type == "revolute":
            yield loop.link_a, "a_axis", _point_on_axis(loop.a_from_frame, loop)
            yield loop.link_b, "b_axis", _point_on_axis(loop.b_from_frame, loop)

    def write_sites(self, body: Element, link: str, body_from_link: Array) -> None:
        """Writes the sites on a link or carrier, under its element."""
        for _, name, pose in self._sites_on.get(link, ()):
            element(body, "site", name=name, **placement(body_from_link @ pose))

    def shared_inertial(self, link: str, inertial: Inertial) -> Inertial:
        """Returns the share of a link's inertial that its own body gets, and each carrier that is welded to
        it."""
        count = 1 + self._carrier_counts[link]
        if count == 1:
            return inertial
        return replace(inertial, mass=inertial.mass / count, inertia=frozen(inertial.inertia / count))

    def carrier_inertial(self, carrier: Carrier) -> Inertial:
        """Returns a carrier's share of its link's inertial, in the frame of the carrier."""
        inertial = self._inertials[carrier.carried]
        return moved(self.shared_inertial(carrier.carried, inertial), inverse(carrier.carried_from_carrier))

    def write_equalities(
        self, equality: Element, timestep: float, extras: Mapping[str, Mapping[str, str]]
    ) -> None:
        """Writes a `connect` for each pair of points, and a `weld` for each pair of frames. `extras`: loop →
        the attributes of its stiffness in an MJCF source."""
        taken = {loop.name for loop in self._robot.loops}
        taken |= {relation.name for relation in self._robot.relations}
        for loop in self._robot.loops:
            names = [name for _, name, _ in self._sites[loop.name]]
            kind = "connect" if loop.type in EQUALITY_SUFFIXES else "weld"
            for index, suffix in enumerate(EQUALITY_SUFFIXES.get(loop.type, ("",))):
                name = free_name(loop.name + suffix, taken) if suffix else loop.name
                taken.add(name)
                first, second = names[2 * index : 2 * index + 2]
                stiffness = {"solref": spaced(stable_solref(loop.solref, timestep)), "solimp": MAX_IMPEDANCE}
                attributes = extras.get(loop.name, stiffness)
                element(equality, kind, name=name, site1=first, site2=second, **attributes)


def stable_solref(solref: tuple[float, float], timestep: float) -> tuple[float, float]:
    """Returns the time constant and damping ratio that are stable with a time step [s]: the time constant is
    at least two steps (MuJoCo's documentation, "Solver parameters"). A direct stiffness and damping
    (negative) are not changed."""
    return (max(solref[0], 2.0 * timestep), solref[1]) if solref[0] > 0 else solref


def _carriers(robot: Robot) -> Iterator[Carrier]:
    """Yields the carriers of the loops that points alone do not close."""
    taken, moving = {link.name for link in robot.links}, _moving_links(robot)
    for loop in robot.loops:
        if loop.type in POINTWISE_TYPES:
            continue
        name = free_name(f"{loop.name}_carrier", taken)
        taken.add(name)
        if loop.link_a in moving:
            b_from_frame, dofs = loop.b_from_frame, loop.dofs
            yield Carrier(name, loop, loop.link_b, b_from_frame, dofs, loop.link_a, loop.a_from_frame)
        else:
            # A fixed link may have no mass to share: the other link is carried, by the reversed chain.
            dofs = _reversed(loop.dofs)
            yield Carrier(name, loop, loop.link_a, loop.a_from_frame, dofs, loop.link_b, loop.b_from_frame)


def _moving_links(robot: Robot) -> set[str]:
    """Returns the links that can move relative to the world."""
    if not robot.base.fixed:
        return {link.name for link in robot.links}
    moving: set[str] = set()
    for joint in robot.joints:
        if joint.dofs or joint.parent in moving:
            moving.add(joint.child)
    return moving


def _reversed(dofs: tuple[Dof, ...]) -> tuple[Dof, ...]:
    """Returns the chain in the opposite direction: (Π O M)⁻¹ as a chain of dofs, with the same values. O is
    the origin of a dof, the identity for the first, and M its motion."""
    origins = [frozen(np.eye(4)), *(frozen(inverse(dof.origin)) for dof in dofs[:0:-1])]
    return tuple(
        replace(dof, axis=frozen(-dof.axis), origin=origin)
        for dof, origin in zip(reversed(dofs), origins, strict=True)
    )


def _point_on_axis(link_from_frame: Array, loop: Loop) -> Array:
    """Returns link_from_point (4, 4): the frame of a hinge, moved along its axis by the lever of the loop."""
    link_from_point = np.array(link_from_frame)
    (dof,) = loop.dofs
    # The direction is that of the mate: the sign with which the user counts must not move the point.
    link_from_point[:3, 3] += link_from_frame[:3, :3] @ dof.axis * dof.mate_value.sign * loop.lever
    return link_from_point
