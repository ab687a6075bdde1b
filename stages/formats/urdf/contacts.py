"""Finds the links of a URDF that do not collide, for writing and checking an SRDF."""

from collections.abc import Iterable, Mapping, Sequence, Set

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.fusing import members
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.model.semantics import NEVER
from linkwright.stages.robot.motion.adjacency import Pair, adjacent_pairs

Reason = str
"""A reason in the words of MoveIt's assistant. Adjacent: next to each other; Default: touching in every pose;
User: the configuration or an MJCF source says so; Never: never touching. Pairs of the source's SRDF keep
their own reasons."""


def excluded_pairs(written: Written) -> tuple[dict[Pair, Reason], tuple[Pair, ...]]:
    """Returns the pairs of links of the URDF that do not collide, in order, with the reasons.

    Pairs that never meet are included only if the source's SRDF has them. The second value has those of the
    pairs of which only some colliders do not collide: an SRDF can only exclude whole links.
    """
    robot, geometry = written.robot, written.shapes
    groups = members(robot, written.as_urdf.held)
    solid = {shape.link for shape in geometry.shapes if shape.role == "collision"}
    parts = {link: [part for part, _ in held if part in solid] for link, held in groups.items()}
    solid_links = [link for link, link_parts in parts.items() if link_parts]
    at = {link: number for number, link in enumerate(solid_links)}
    if not geometry.self_contact:
        joined = _joined(written.as_urdf.robot, {*solid_links})
        return dict.fromkeys(joined, "Adjacent") | _of_source(robot, parts, at), ()
    adjacent = frozenset(adjacent_pairs(robot, solid))
    excludes = {(exclude.link_a, exclude.link_b): exclude for exclude in geometry.excludes}
    place = _places(robot)
    reasons: dict[Pair, Reason] = {}
    partly: list[Pair] = []
    # Other pairs of links are unknown, and a large robot has too many to look at each.
    for pair in _near((*adjacent, *excludes), parts, at):
        robot_pairs = _pairs_of(place, parts, pair)
        pair_excludes = [excludes.get(robot_pair) for robot_pair in robot_pairs]
        if not adjacent.isdisjoint(robot_pairs):
            reasons[pair] = "Adjacent"
            continue
        if any(exclude is not None and exclude.reason == "Always" for exclude in pair_excludes):
            reasons[pair] = "Default"
        elif all(pair_excludes):
            reasons[pair] = "User"
        else:
            continue
        if not all(exclude is not None and not exclude.geoms for exclude in pair_excludes):
            partly.append(pair)
    reasons |= _of_source(robot, parts, at)
    return {
        pair: reasons[pair] for pair in sorted(reasons, key=lambda both: (at[both[0]], at[both[1]]))
    }, tuple(partly)


def _of_source(robot: Robot, parts: Mapping[str, Sequence[str]], at: Mapping[str, int]) -> dict[Pair, Reason]:
    """Returns the pairs of the source's SRDF with their reasons. For links that consist of several of its
    links, all pairs of these must be disabled."""
    source = {(pair.link_a, pair.link_b): pair.reason for pair in robot.semantics.disabled}
    place = _places(robot)
    source_reasons = {}
    for pair in _near(source, parts, at):
        reasons = [source.get(robot_pair) for robot_pair in _pairs_of(place, parts, pair)]
        if None not in reasons:
            source_reasons[pair] = next((reason for reason in reasons if reason != NEVER), NEVER) or ""
    return source_reasons


def _near(pairs: Iterable[Pair], parts: Mapping[str, Sequence[str]], at: Mapping[str, int]) -> list[Pair]:
    """Returns the pairs of links of the URDF that contain these pairs of the robot's links, in order. `at`:
    the index of each link of the URDF."""
    holder = {part: link for link in at for part in parts[link]}
    urdf_pairs = {
        tuple(sorted((holder[a], holder[b]), key=at.__getitem__))
        for a, b in pairs
        if a in holder and b in holder and holder[a] != holder[b]
    }
    return sorted(((a, b) for a, b in urdf_pairs), key=lambda pair: (at[pair[0]], at[pair[1]]))


def _pairs_of(place: Mapping[str, int], parts: Mapping[str, Sequence[str]], pair: Pair) -> list[Pair]:
    """Returns the pairs of the robot's links in two links of the URDF. `place`: the index of each link of the
    robot; each pair is in this order."""
    return [(a, b) if place[a] < place[b] else (b, a) for a in parts[pair[0]] for b in parts[pair[1]]]


def _places(robot: Robot) -> dict[str, int]:
    """Returns the index of each link of a robot."""
    return {link.name: number for number, link in enumerate(robot.links)}


def _joined(robot: Robot, solid: Set[str]) -> list[Pair]:
    """Returns the pairs of links that a joint or a loop joins, in the order of the links."""
    place = _places(robot)
    joined = [(joint.parent, joint.child) for joint in robot.joints if joint.type != "free"]
    joined += [(loop.link_a, loop.link_b) for loop in robot.loops if loop.type != "free"]
    pairs = {tuple(sorted(pair, key=place.__getitem__)) for pair in joined if solid >= set(pair)}
    return sorted(((a, b) for a, b in pairs if a != b), key=lambda pair: (place[pair[0]], place[pair[1]]))
