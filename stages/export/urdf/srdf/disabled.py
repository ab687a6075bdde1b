"""The pairs of links that MoveIt does not check for collisions."""

from collections.abc import Set
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

from stages.export.urdf.srdf.apart import apart
from stages.export.urdf.srdf.convex import bodies_of
from stages.formats.urdf.as_written import as_written, holders
from stages.formats.urdf.form import UrdfForm
from stages.robot.adjacency import Pair, adjacent_pairs
from stages.robot.fusing import members
from stages.robot.geometry import Geometry
from stages.robot.model import Robot
from stages.robot.start_pose import home

Reason = Literal["Adjacent", "Default", "User", "Never"]
"""In the words of MoveIt's assistant: next to each other; touching in every pose; the configuration says so;
never touching."""


@dataclass(frozen=True, slots=True)
class Disabled:
    """`pairs`: by links of the URDF, in their order. `partly`: those of them of which only some colliders do
    not collide."""

    pairs: tuple[tuple[Pair, Reason], ...]
    partly: tuple[Pair, ...]


def disabled_pairs(robot: Robot, geometry: Geometry, form: UrdfForm) -> Disabled:
    """The pairs of a URDF of this form."""
    written = as_written(robot, form)
    groups = members(robot, holders(robot, form))
    if not geometry.self_contact:
        solid = {shape.link for shape in geometry.shapes if shape.role == "collision"}
        with_colliders = {link for link, parts in groups.items() if any(one in solid for one, _ in parts)}
        return Disabled(tuple((pair, "Adjacent") for pair in _joined(written, with_colliders)), ())
    bodies = bodies_of(geometry, groups)
    order = [link.name for link in robot.links if link.name in bodies]
    solid = {shape.link for shape in geometry.shapes if shape.role == "collision"}
    parts = {link: [one for one, _ in groups[link] if one in solid] for link in order}
    place = {link.name: number for number, link in enumerate(robot.links)}
    adjacent = frozenset(adjacent_pairs(robot, solid))
    given = {(one.link_a, one.link_b): one for one in geometry.excludes}
    found: dict[Pair, Reason] = {}
    partly: list[Pair] = []
    for pair in combinations(order, 2):
        own = [(a, b) if place[a] < place[b] else (b, a) for a in parts[pair[0]] for b in parts[pair[1]]]
        known = [given.get(one) for one in own]
        if not adjacent.isdisjoint(own):
            found[pair] = "Adjacent"
        elif any(one is not None and one.reason == "Always" for one in known):
            found[pair] = "Default"
            if not all(one is not None and not one.geoms for one in known):
                partly.append(pair)
        elif all(known):
            found[pair] = "User"
    if {loop.name for loop in robot.loops} == set(form.closed):
        # The relations of the URDF alone close them, which is quicker worked out.
        written = replace(written, loops=())
    found |= dict.fromkeys(apart(written, home(robot), bodies, found), "Never")
    pairs = [(pair, found[pair]) for pair in combinations(order, 2) if pair in found]
    return Disabled(tuple(pairs), tuple(partly))


def _joined(robot: Robot, solid: Set[str]) -> list[Pair]:
    """The pairs of links that a joint or a loop joins, in the order of the links."""
    place = {link.name: number for number, link in enumerate(robot.links)}
    joined = [(one.parent, one.child) for one in robot.joints if one.type != "free"]
    joined += [(one.link_a, one.link_b) for one in robot.loops if one.type != "free"]
    pairs = {tuple(sorted(pair, key=place.__getitem__)) for pair in joined if solid >= set(pair)}
    return sorted(((a, b) for a, b in pairs if a != b), key=lambda pair: (place[pair[0]], place[pair[1]]))
