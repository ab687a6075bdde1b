"""Which links of a URDF do not collide, as far as the robot says: for who writes or checks an SRDF."""

from collections.abc import Set
from typing import Literal

from stages.formats.urdf.as_written import as_written, holders
from stages.formats.urdf.form import UrdfForm
from stages.robot.adjacency import Pair, adjacent_pairs
from stages.robot.fusing import members
from stages.robot.geometry import Geometry
from stages.robot.model import Robot

Reason = Literal["Adjacent", "Default", "User", "Never"]
"""In the words of MoveIt's assistant: next to each other; touching in every pose; the configuration says so;
never touching."""


def known_pairs(
    robot: Robot, geometry: Geometry, form: UrdfForm
) -> tuple[dict[Pair, Reason], tuple[Pair, ...]]:
    """The pairs of links of a URDF of this form that do not collide, in their order, with the reasons,
    without those that never meet; and those of them of which only some colliders do not collide."""
    groups = members(robot, holders(robot, form))
    solid = {shape.link for shape in geometry.shapes if shape.role == "collision"}
    order = [link for link, parts in groups.items() if any(one in solid for one, _ in parts)]
    if not geometry.self_contact:
        joined = _joined(as_written(robot, form), {*order})
        return dict.fromkeys(joined, "Adjacent"), ()
    parts = {link: [one for one, _ in groups[link] if one in solid] for link in order}
    place = {link.name: number for number, link in enumerate(robot.links)}
    adjacent = frozenset(adjacent_pairs(robot, solid))
    given = {(one.link_a, one.link_b): one for one in geometry.excludes}
    found: dict[Pair, Reason] = {}
    partly: list[Pair] = []
    holder = {one: link for link in order for one in parts[link]}
    at = {link: number for number, link in enumerate(order)}
    # Of any other pair of links nothing is known: a large robot has too many to look at each.
    near = {
        tuple(sorted((holder[a], holder[b]), key=at.__getitem__))
        for a, b in (*adjacent, *given)
        if a in holder and b in holder and holder[a] != holder[b]
    }
    for one, other in sorted(near, key=lambda both: (at[both[0]], at[both[1]])):
        pair = (one, other)
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
    return found, tuple(partly)


def _joined(robot: Robot, solid: Set[str]) -> list[Pair]:
    """The pairs of links that a joint or a loop joins, in the order of the links."""
    place = {link.name: number for number, link in enumerate(robot.links)}
    joined = [(one.parent, one.child) for one in robot.joints if one.type != "free"]
    joined += [(one.link_a, one.link_b) for one in robot.loops if one.type != "free"]
    pairs = {tuple(sorted(pair, key=place.__getitem__)) for pair in joined if solid >= set(pair)}
    return sorted(((a, b) for a, b in pairs if a != b), key=lambda pair: (place[pair[0]], place[pair[1]]))
