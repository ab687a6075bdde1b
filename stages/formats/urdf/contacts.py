"""Which links of a URDF do not collide, as far as the robot says: for who writes or checks an SRDF."""

from collections.abc import Iterable, Mapping, Sequence, Set

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.fusing import members
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.model.semantics import NEVER
from linkwright.stages.robot.motion.adjacency import Pair, adjacent_pairs

Reason = str
"""In the words of MoveIt's assistant, Adjacent: next to each other; Default: touching in every pose; User:
the configuration says so; Never: never touching. Of pairs of the source's SRDF, its own words."""


def known_pairs(written: Written) -> tuple[dict[Pair, Reason], tuple[Pair, ...]]:
    """The pairs of links of the URDF that do not collide, in their order, with the reasons; of
    those that never meet only the ones that the source's SRDF has. And the pairs of which only some colliders
    do not collide."""
    robot, geometry = written.robot, written.shapes
    groups = members(robot, written.as_urdf.held)
    solid = {shape.link for shape in geometry.shapes if shape.role == "collision"}
    parts = {link: [one for one, _ in held if one in solid] for link, held in groups.items()}
    order = [link for link, own in parts.items() if own]
    at = {link: number for number, link in enumerate(order)}
    if not geometry.self_contact:
        joined = _joined(written.as_urdf.robot, {*order})
        return dict.fromkeys(joined, "Adjacent") | _of_source(robot, parts, at), ()
    adjacent = frozenset(adjacent_pairs(robot, solid))
    given = {(one.link_a, one.link_b): one for one in geometry.excludes}
    place = _places(robot)
    found: dict[Pair, Reason] = {}
    partly: list[Pair] = []
    # Of any other pair of links nothing is known: a large robot has too many to look at each.
    for pair in _near((*adjacent, *given), parts, at):
        own = _pairs_of(place, parts, pair)
        known = [given.get(one) for one in own]
        if not adjacent.isdisjoint(own):
            found[pair] = "Adjacent"
        elif any(one is not None and one.reason == "Always" for one in known):
            found[pair] = "Default"
            if not all(one is not None and not one.geoms for one in known):
                partly.append(pair)
        elif all(known):
            found[pair] = "User"
    found |= _of_source(robot, parts, at)
    return {pair: found[pair] for pair in sorted(found, key=lambda both: (at[both[0]], at[both[1]]))}, tuple(
        partly
    )


def _of_source(robot: Robot, parts: Mapping[str, Sequence[str]], at: Mapping[str, int]) -> dict[Pair, Reason]:
    """The pairs that the source's SRDF has: of links that are several of its links, each of these."""
    source = {(pair.link_a, pair.link_b): pair.reason for pair in robot.semantics.disabled}
    place = _places(robot)
    found = {}
    for pair in _near(source, parts, at):
        reasons = [source.get(one) for one in _pairs_of(place, parts, pair)]
        if None not in reasons:
            found[pair] = next((reason for reason in reasons if reason != NEVER), NEVER) or ""
    return found


def _near(pairs: Iterable[Pair], parts: Mapping[str, Sequence[str]], at: Mapping[str, int]) -> list[Pair]:
    """The pairs of links of the URDF that hold pairs of the robot's, in their order. `at`: their places."""
    holder = {one: link for link in at for one in parts[link]}
    near = {
        tuple(sorted((holder[a], holder[b]), key=at.__getitem__))
        for a, b in pairs
        if a in holder and b in holder and holder[a] != holder[b]
    }
    return sorted(((a, b) for a, b in near), key=lambda pair: (at[pair[0]], at[pair[1]]))


def _pairs_of(place: Mapping[str, int], parts: Mapping[str, Sequence[str]], pair: Pair) -> list[Pair]:
    """The pairs of the robot's links in two links of the URDF, each in the robot's order, their `place`."""
    return [(a, b) if place[a] < place[b] else (b, a) for a in parts[pair[0]] for b in parts[pair[1]]]


def _places(robot: Robot) -> dict[str, int]:
    return {link.name: number for number, link in enumerate(robot.links)}


def _joined(robot: Robot, solid: Set[str]) -> list[Pair]:
    """The pairs of links that a joint or a loop joins, in the order of the links."""
    place = _places(robot)
    joined = [(one.parent, one.child) for one in robot.joints if one.type != "free"]
    joined += [(one.link_a, one.link_b) for one in robot.loops if one.type != "free"]
    pairs = {tuple(sorted(pair, key=place.__getitem__)) for pair in joined if solid >= set(pair)}
    return sorted(((a, b) for a, b in pairs if a != b), key=lambda pair: (place[pair[0]], place[pair[1]]))
