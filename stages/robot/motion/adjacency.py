"""Finds adjacent links, whose contact means nothing, since joints hold them together."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import combinations, product

from linkwright.stages.robot.model.robot import Robot

Pair = tuple[str, str]
"""Two links, in the order of the robot's links."""


def adjacent_pairs(robot: Robot, colliding: Collection[str]) -> tuple[Pair, ...]:
    """Returns the pairs of `colliding` links that never collide, in the order of the links:

    - links that cannot move against each other: joined rigidly, or both fixed to the world;
    - links joined by a joint or a loop, and the links joined rigidly to either; of links that are fixed to
      the world only the link that has the joint, since the rest of a workplace is an obstacle;
    - links on either side of a link without a collider, as if a joint connected them, or on either side of
      any number of such links that are not seen either. Where more than two joints meet in such a link,
      that holds between the link above it and each link below: two fingers of a hand without a collider are
      not adjacent. A hand at the end of an arm of seen links without colliders is not adjacent to the link
      that carries the arm.

    A free joint joins nothing.
    """
    bodies = _bodies(robot)
    solid = {bodies.of[link] for link in colliding}
    neighbours = {
        (body, other) for body in solid for other in _neighbours(body, solid, bodies) if other != body
    }
    colliding_links = set(colliding)
    order = [link.name for link in robot.links if link.name in colliding_links]
    members: dict[str, list[int]] = {}
    for place, link in enumerate(order):
        members.setdefault(bodies.of[link], []).append(place)
    fixed = [place for body in bodies.fixed & members.keys() for place in members[body]]
    pairs = {tuple(sorted(pair)) for group in (fixed, *members.values()) for pair in combinations(group, 2)}
    pairs |= {
        tuple(sorted(pair))
        for first, second in neighbours
        for pair in product(members[first], members[second])
    }
    return tuple((order[first], order[second]) for first, second in sorted(pairs))


@dataclass(frozen=True, slots=True)
class _RigidBodies:
    """Links grouped into rigid bodies, named by their first link. Each link fixed to the world is a body of
    its own."""

    of: dict[str, str]
    """Link → body."""
    fixed: frozenset[str]
    seen: frozenset[str]
    """Bodies that have a mesh or a primitive."""
    edges: dict[str, list[tuple[int, str]]]
    """Body → its connections: their number, and the body on the other side."""
    above: dict[str, int]
    """Body → number of the joint to its parent."""


def _bodies(robot: Robot) -> _RigidBodies:
    root = robot.root.name
    body_of = {root: root}
    fixed = {root} if robot.base.fixed else set[str]()
    connections: list[Pair] = []
    parent_edges: dict[str, int] = {}
    for joint in robot.joints:
        body = body_of[joint.child] = joint.child
        if not joint.dofs and joint.parent in fixed:
            fixed.add(joint.child)
        elif not joint.dofs:
            body_of[joint.child] = body_of[joint.parent]
            continue
        if joint.type != "free":
            parent_edges[body] = len(connections)
            connections.append((body_of[joint.parent], body))
    connections += [
        (body_of[loop.link_a], body_of[loop.link_b]) for loop in robot.loops if loop.type != "free"
    ]
    edges: dict[str, list[tuple[int, str]]] = {body: [] for body in body_of.values()}
    for number, (first, second) in enumerate(connections):
        if first != second:
            edges[first].append((number, second))
            edges[second].append((number, first))
    visible = {
        body_of[link.name] for link in robot.links if link.shapes or any(part.mesh for part in link.parts)
    }
    return _RigidBodies(body_of, frozenset(fixed), frozenset(visible), edges, parent_edges)


def _neighbours(body: str, solid: Collection[str], bodies: _RigidBodies) -> Iterator[str]:
    """Yields the bodies with a collider that are adjacent to this body, which may be among them."""
    waiting = [(*edge, 0) for edge in bodies.edges[body]]
    visited: set[tuple[int, str, int]] = set()
    while waiting:
        came, other, passed = step = waiting.pop()
        if step in visited:
            continue
        visited.add(step)
        if other in solid:
            yield other
            continue
        passed += other in bodies.seen
        if passed > 1:
            continue
        edges = bodies.edges[other]
        over = bodies.above.get(other, -1)
        onwards = [
            candidate
            for candidate in edges
            if candidate[0] != came and (len(edges) == 2 or over in (came, candidate[0]))
        ]
        waiting += [(*candidate, passed) for candidate in onwards]
