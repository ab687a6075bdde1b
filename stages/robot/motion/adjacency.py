"""Which links are next to each other, so that their contact means nothing: joints hold them together."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import combinations, product

from linkwright.stages.robot.model.robot import Robot

Pair = tuple[str, str]
"""Two links, in the order of the robot's links."""


def adjacent_pairs(robot: Robot, colliding: Collection[str]) -> tuple[Pair, ...]:
    """The pairs of `colliding` links that never collide, in the order of the links:

    - links that cannot move against each other: joined rigidly, or both fixed to the world;
    - links joined by a joint or a loop, and what is joined rigidly to the one or the other; of links that
      are fixed to the world only the one that has the joint, since the rest of a workplace is an obstacle;
    - links on either side of a link without a collider, as if one joint were there, and of any number of them
      that are not seen either. Where more than two joints meet in such a link, that holds between what is
      above it and each below: two fingers of a hand without a collider are not next to each other. A hand
      at the end of an arm of seen links without colliders is not next to what carries the arm.

    A free joint joins nothing.
    """
    bodies = _bodies(robot)
    solid = {bodies.of[link] for link in colliding}
    near = {(body, other) for body in solid for other in _neighbours(body, solid, bodies) if other != body}
    wanted = set(colliding)
    order = [link.name for link in robot.links if link.name in wanted]
    members: dict[str, list[int]] = {}
    for place, link in enumerate(order):
        members.setdefault(bodies.of[link], []).append(place)
    fixed = [place for body in bodies.fixed & members.keys() for place in members[body]]
    found = {tuple(sorted(pair)) for group in (fixed, *members.values()) for pair in combinations(group, 2)}
    found |= {tuple(sorted(pair)) for one, other in near for pair in product(members[one], members[other])}
    return tuple((order[one], order[other]) for one, other in sorted(found))


@dataclass(frozen=True, slots=True)
class _RigidBodies:
    """Links that are one body, named by its first link; a link that is fixed to the world is one of its own.

    `seen`: those that have a mesh or a primitive. `edges`: by body, the numbers of the connections with what
    is on the other side; `above`: by body, the number of the joint to what it hangs on.
    """

    of: dict[str, str]
    fixed: frozenset[str]
    seen: frozenset[str]
    edges: dict[str, list[tuple[int, str]]]
    above: dict[str, int]


def _bodies(robot: Robot) -> _RigidBodies:
    root = robot.root.name
    of = {root: root}
    fixed = {root} if robot.base.fixed else set[str]()
    connections: list[Pair] = []
    above: dict[str, int] = {}
    for joint in robot.joints:
        body = of[joint.child] = joint.child
        if not joint.dofs and joint.parent in fixed:
            fixed.add(joint.child)
        elif not joint.dofs:
            of[joint.child] = of[joint.parent]
            continue
        if joint.type != "free":
            above[body] = len(connections)
            connections.append((of[joint.parent], body))
    connections += [(of[loop.link_a], of[loop.link_b]) for loop in robot.loops if loop.type != "free"]
    edges: dict[str, list[tuple[int, str]]] = {body: [] for body in of.values()}
    for number, (one, other) in enumerate(connections):
        if one != other:
            edges[one].append((number, other))
            edges[other].append((number, one))
    seen = {of[link.name] for link in robot.links if link.shapes or any(part.mesh for part in link.parts)}
    return _RigidBodies(of, frozenset(fixed), frozenset(seen), edges, above)


def _neighbours(body: str, solid: Collection[str], bodies: _RigidBodies) -> Iterator[str]:
    """The bodies that have a collider and are next to this, which may be among them."""
    waiting = [(*edge, 0) for edge in bodies.edges[body]]
    done: set[tuple[int, str, int]] = set()
    while waiting:
        came, other, passed = step = waiting.pop()
        if step in done:
            continue
        done.add(step)
        if other in solid:
            yield other
            continue
        passed += other in bodies.seen
        if passed > 1:
            continue
        ways = bodies.edges[other]
        over = bodies.above.get(other, -1)
        onwards = [way for way in ways if way[0] != came and (len(ways) == 2 or over in (came, way[0]))]
        waiting += [(*way, passed) for way in onwards]
