"""How a mechanism can move: its coordinates less the conditions of relations and loops, by rank.

A loop asks that the twist of its frame by way of link a equals the one by way of link b, but for
what its own dofs let move: 6 − f rows over the coordinates on both ways (Angeles, "Fundamentals of
Robotic Mechanical Systems", on the rank of the Jacobian of a closed chain). Lengths are
measured by the reach of what hangs together, so that all entries are about 1.

The rank is that at the saved pose: where the pose is singular (a parallelogram that lies flat, with all
its pivots in line) it is lower than elsewhere, and `dof` counts motions that are not there a step on.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import networkx as nx
import numpy as np

from stages.graph.notes import Notes
from stages.robot.kinematics import link_poses, saved_configuration
from stages.robot.model import Array, Dof, Loop, Mobility, Relation, Robot
from stages.robot.poses import motion

FREEDOM = {"turn": 1, "slide": 1, "ball": 3, "free": 6}

RANK_TOLERANCE = 1e-6
"""A singular value of entries of about 1 that is below this counts as zero: a saved pose is met to
about 1e-8."""


@dataclass(frozen=True, slots=True, eq=False)
class Coordinate:
    """A scalar motion at the saved pose, in the root's frame: `spin` and `shift` (3,) are its angular
    velocity and the velocity of the point `at` (3,) for a unit rate."""

    dof: str
    spin: Array
    shift: Array
    at: Array

    def twist(self, point: Array, reach: float) -> Array:
        """(6,): the angular velocity, and that of `point` measured by `reach` [m]. A slide's rate is
        measured so too."""
        if not self.spin.any():
            return np.concatenate([self.spin, self.shift])
        return np.concatenate([self.spin, (self.shift + np.cross(self.spin, point - self.at)) / reach])


@dataclass(frozen=True, slots=True, eq=False)
class _Ring:
    """A loop's coordinates: those on the way to link a, to link b, and the loop's own, and its point."""

    loop: Loop
    to_a: tuple[Coordinate, ...]
    to_b: tuple[Coordinate, ...]
    own: tuple[Coordinate, ...]
    point: Array


def with_mobility(robot: Robot, notes: Notes) -> Robot:
    """The robot with its mobility; tells loops that lock what they join (W-RIGID-LOOP).

    A loop's redundant conditions are those that follow from the relations and from the loops before it
    by name.
    """
    coordinates = sum(FREEDOM[dof.kind] for dof in robot.dofs)
    taken = len(robot.relations) + sum(_conditions(loop) for loop in robot.loops)
    rank, redundant = 0, dict[str, int]()
    for relations, rings in _groups(robot):
        matrix, counts, index = _stacked(relations, rings)
        ranks = [_rank(matrix[:count]) for count in counts]
        rank += ranks[-1]
        for ring, before, after in zip(rings, ranks, ranks[1:], strict=False):
            redundant[ring.loop.name] = _conditions(ring.loop) - (after - before)
        _tell_rigid(rings, _motions(matrix), index, notes)
    found = tuple((name, count) for name, count in sorted(redundant.items()) if count)
    return replace(robot, mobility=Mobility(coordinates, coordinates - taken, coordinates - rank, found))


def _conditions(loop: Loop) -> int:
    return 6 - sum(FREEDOM[dof.kind] for dof in loop.dofs)


def _groups(robot: Robot) -> Iterator[tuple[list[Relation], list[_Ring]]]:
    """Relations and loops that share coordinates, loops in the order of their names."""
    rings = _rings(robot)
    graph: nx.Graph[str] = nx.Graph()
    for relation in robot.relations:
        graph.add_edge(relation.driver, relation.follower)
    for ring in rings:
        names = [one.dof for one in (*ring.to_a, *ring.to_b)]
        nx.add_path(graph, names)
    groups = sorted(sorted(group) for group in nx.connected_components(graph))
    for group in groups:
        inside = set(group)
        yield (
            [one for one in robot.relations if one.driver in inside],
            [ring for ring in rings if any(one.dof in inside for one in (*ring.to_a, *ring.to_b))],
        )
    for ring in rings:
        if not (ring.to_a or ring.to_b):
            yield [], [ring]


def _rings(robot: Robot) -> list[_Ring]:
    q = saved_configuration(robot)
    poses = link_poses(robot, q)
    of_joint = {
        joint.name: tuple(_coordinates(joint.dofs, poses[joint.parent] @ joint.parent_from_joint))
        for joint in robot.joints
    }
    above = {joint.child: joint for joint in robot.joints}

    def way(link: str) -> list[str]:
        names = []
        while link in above:
            names.append(above[link].name)
            link = above[link].parent
        return names

    rings = []
    for loop in sorted(robot.loops, key=lambda one: one.name):
        ways = way(loop.link_a), way(loop.link_b)
        sides = [
            tuple(one for name in reversed(mine) if name not in other for one in of_joint[name])
            for mine, other in (ways, ways[::-1])
        ]
        own = tuple(_coordinates(loop.dofs, poses[loop.link_b] @ loop.b_from_frame))
        point = (poses[loop.link_a] @ loop.a_from_frame)[:3, 3]
        rings.append(_Ring(loop, sides[0], sides[1], own, point))
    return rings


def _coordinates(dofs: Iterable[Dof], root_from_start: Array) -> Iterator[Coordinate]:
    """The scalar motions of a chain of dofs that starts at this pose (4, 4), at its saved values."""
    pose, none = root_from_start, np.zeros(3)
    for dof in dofs:
        pose = pose @ dof.origin
        moved = pose @ motion(dof.kind, dof.axis, dof.saved)
        axis = pose[:3, :3] @ dof.axis
        if dof.kind == "turn":
            yield Coordinate(dof.name, axis, none, pose[:3, 3])
        elif dof.kind == "slide":
            yield Coordinate(dof.name, none, axis, pose[:3, 3])
        else:
            for across in moved[:3, :3].T:
                yield Coordinate(dof.name, across, none, moved[:3, 3])
            for along in moved[:3, :3].T if dof.kind == "free" else ():
                yield Coordinate(dof.name, none, along, moved[:3, 3])
        pose = moved


def _stacked(
    relations: Sequence[Relation], rings: Sequence[_Ring]
) -> tuple[Array, list[int], Mapping[str, list[int]]]:
    """The rows of all conditions, relations first; how many there are before the first loop and after
    each; and the columns of each dof."""
    index: dict[str, list[int]] = {}
    column: dict[Coordinate, int] = {}
    known = dict.fromkeys(one for ring in rings for one in (*ring.to_a, *ring.to_b))
    for number, one in enumerate(known):
        column[one] = number
        index.setdefault(one.dof, []).append(number)
    width = len(known)
    for relation in relations:
        for name in (relation.driver, relation.follower):
            if name not in index:
                index[name], width = [width], width + 1
    reach = _reach(rings)
    slides = {one.dof for one in known if not one.spin.any()}
    blocks = [np.zeros((0, width))]
    for relation in relations:
        row = np.zeros((1, width))
        scale = {name: reach if name in slides else 1.0 for name in (relation.driver, relation.follower)}
        row[0, index[relation.follower][0]] = scale[relation.follower]
        row[0, index[relation.driver][0]] = -relation.multiplier * scale[relation.driver]
        blocks.append(row / np.linalg.norm(row))
    for ring in rings:
        block = np.zeros((6, width))
        for sign, side in ((1.0, ring.to_a), (-1.0, ring.to_b)):
            for one in side:
                block[:, column[one]] = sign * one.twist(ring.point, reach)
        blocks.append(_locked(ring, reach) @ block)
    counts = np.cumsum([len(block) for block in blocks])[len(relations) :]
    return np.vstack(blocks), [int(count) for count in counts], index


def _reach(rings: Sequence[_Ring]) -> float:
    """The largest distance [m] of a coordinate from the point of a loop that it is in; 1 without any."""
    far = [float(np.linalg.norm(one.at - ring.point)) for ring in rings for one in (*ring.to_a, *ring.to_b)]
    return max(far, default=0.0) or 1.0


def _locked(ring: _Ring, reach: float) -> Array:
    """(6 − f, 6): an orthonormal basis of the twists that the loop's own dofs do not let through."""
    if not ring.own:
        return np.eye(6)
    free = np.column_stack([one.twist(ring.point, reach) for one in ring.own])
    basis: Array = np.linalg.svd(free)[0][:, free.shape[1] :].T
    return basis


def _rank(matrix: Array) -> int:
    if not matrix.size:
        return 0
    sizes = np.linalg.svd(matrix, compute_uv=False)
    # Conditions that a plane fulfils are all rounding: measured by the largest they would count.
    return int((sizes > RANK_TOLERANCE * max(1.0, float(sizes[0]))).sum())


def _motions(matrix: Array) -> Array:
    """(n, d): the directions in which the conditions let n coordinates move."""
    if not matrix.size:
        return np.eye(matrix.shape[1])
    return np.asarray(np.linalg.svd(matrix)[2][_rank(matrix) :].T)


def _tell_rigid(rings: Sequence[_Ring], motions: Array, index: Mapping[str, list[int]], notes: Notes) -> None:
    for ring in rings:
        names = list(dict.fromkeys(one.dof for one in (*ring.to_a, *ring.to_b)))
        columns = [column for name in names for column in index[name]]
        if columns and not (np.abs(motions[columns]) > RANK_TOLERANCE).any():
            text = f"the loop leaves no motion to {', '.join(names)}"
            hint = "take away a mate or a relation of the loop, or FASTEN what is meant to be rigid"
            notes.tell("W-RIGID-LOOP", text, ring.loop.name, hint)
