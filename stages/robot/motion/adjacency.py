"""Finds adjacent links, whose contact has no meaning, since joints hold them together."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import combinations, product

from linkwright.stages.robot.model.robot import Robot

Pair = tuple[str, str]
"""Two links, in the order of the robot's links."""


def adjacent_pairs(robot: Robot, colliding: Collection[str]) -> tuple[Pair, ...]:
    """Returns the pairs of `colliding` links that are adjacent, in the order of the links. `colliding`: the
    links with a collider. Adjacent are:

    - links that cannot move against each other: joined rigidly, or both fixed to the world;
    - links that a joint or a loop connects, and the links joined rigidly to either. Of links that are fixed
      to the world it is only the link with the joint, since the rest of a workplace is an obstacle;
    - links that are connected through links without colliders, of which at most one is seen. A hand at the
      end of an arm of several seen links without colliders is not adjacent to the link that carries the arm.
      If more than two joints meet in a link without a collider, only the link above it is adjacent to the
      links below: two fingers of a hand without a collider are not adjacent.

    A free joint does not connect links.
    """
    bodies = _bodies(robot)
    solid = {bodies.body_of[link] for link in colliding}
    neighbours = {
        (body, neighbour)
        for body in solid
        for neighbour in _neighbours(body, solid, bodies)
        if neighbour != body
    }
    colliding_links = set(colliding)
    order = [link.name for link in robot.links if link.name in colliding_links]
    members: dict[str, list[int]] = {}
    for place, link in enumerate(order):
        members.setdefault(bodies.body_of[link], []).append(place)
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
    """Links grouped into rigid bodies, which are named by their first link. Each link that is fixed to the
    world is a body of its own."""

    body_of: dict[str, str]
    """Link → body."""
    fixed: frozenset[str]
    """Bodies that are fixed to the world."""
    seen: frozenset[str]
    """Bodies that have a mesh or a primitive."""
    edges: dict[str, list[tuple[int, str]]]
    """Body → its connections: (index of the connection, body on the other side)."""
    parent_edges: dict[str, int]
    """Body → index of the connection to its parent."""


def _bodies(robot: Robot) -> _RigidBodies:
    root = robot.root.name
    body_of = {root: root}
    fixed = {root} if robot.base.fixed else set[str]()
    # The two bodies of each joint and loop.
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
    """Yields the bodies in `solid`, those with a collider, that are adjacent to this body; it may be among
    them."""
    # A step: the connection that leads to a body, the body, and the number of seen bodies before it.
    steps = [(*edge, 0) for edge in bodies.edges[body]]
    visited: set[tuple[int, str, int]] = set()
    while steps:
        entrance, current, seen_count = step = steps.pop()
        if step in visited:
            continue
        visited.add(step)
        if current in solid:
            yield current
            continue
        seen_count += current in bodies.seen
        if seen_count > 1:
            continue
        edges = bodies.edges[current]
        to_parent = bodies.parent_edges.get(current, -1)
        for exit_edge, neighbour in edges:
            if exit_edge != entrance and (len(edges) == 2 or to_parent in (entrance, exit_edge)):
                steps.append((exit_edge, neighbour, seen_count))
