"""The mobility of a mechanism: its coordinates less the conditions of relations and loops, by rank.

A loop requires that the twist of its frame by way of link a equals that by way of link b, except for
the motions of its own dofs: 6 − f rows over the coordinates on both ways (Angeles, "Fundamentals of
Robotic Mechanical Systems", on the rank of the Jacobian of a closed chain). Lengths are
measured by the reach of connected loops, so that all entries are about 1.

The rank is that at the saved pose: where the pose is singular (a parallelogram that lies flat, with all
its pivots in line) it is lower than elsewhere, and `dof` counts motions that are not there a step on.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import motion
from linkwright.stages.robot.model.robot import Array, Dof, Loop, Mobility, Robot
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from linkwright.stages.robot.motion.tree_paths import ways_up

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


@dataclass(frozen=True, slots=True, eq=False)
class _Ring:
    """A loop's coordinates: those on the way to link a, to link b, and the loop's own, and its point."""

    loop: Loop
    to_a: tuple[Coordinate, ...]
    to_b: tuple[Coordinate, ...]
    own: tuple[Coordinate, ...]
    point: Array

    @property
    def way(self) -> tuple[Coordinate, ...]:
        """The coordinates all the way round, without the loop's own."""
        return self.to_a + self.to_b


@dataclass(frozen=True, slots=True)
class Share:
    """How a dof moves with its driver: by `multiplier`, times the reach to the `power` where rates of
    slides are measured by that."""

    driver: str
    multiplier: float
    power: int


def with_mobility(robot: Robot, log: Diagnostics) -> Robot:
    """The robot with its mobility. W-RIGID-LOOP for loops that lock the links that they join.

    A loop's redundant conditions are those that follow from the relations and from the loops before it
    by name.
    """
    coordinates = sum(FREEDOM[dof.kind] for dof in robot.dofs)
    taken = len(robot.relations) + sum(_conditions(loop) for loop in robot.loops)
    # Relations are trees: none of them follows from others.
    rank, redundant = len(robot.relations), dict[str, int]()
    shares = _shares(robot)
    for rings in _groups(_rings(robot), shares):
        blocks, columns = _stacked(rings, shares)
        whole, moving = _solved(np.vstack(blocks))
        rank += whole
        for ring, added in zip(rings, _added(blocks, 0, whole), strict=True):
            redundant[ring.loop.name] = _conditions(ring.loop) - added
        _report_rigid(rings, moving, columns, log)
    found = tuple((name, count) for name, count in sorted(redundant.items()) if count)
    return replace(robot, mobility=Mobility(coordinates, coordinates - taken, coordinates - rank, found))


def _conditions(loop: Loop) -> int:
    return 6 - sum(FREEDOM[dof.kind] for dof in loop.dofs)


def _groups(rings: Sequence[_Ring], shares: Mapping[str, Share]) -> list[list[_Ring]]:
    """Loops that share coordinates, by themselves or through relations, in the order of their names."""
    forest = nx.utils.UnionFind(range(len(rings)))
    first: dict[str, int] = {}
    for number, ring in enumerate(rings):
        for name in {shares[one.dof].driver if one.dof in shares else one.dof for one in ring.way}:
            forest.union(number, first.setdefault(name, number))
    groups: dict[int, list[_Ring]] = {}
    for number, ring in enumerate(rings):
        groups.setdefault(forest[number], []).append(ring)
    return list(groups.values())


def _rings(robot: Robot) -> list[_Ring]:
    poses = link_poses(robot, saved_configuration(robot))
    above = {joint.child: joint for joint in robot.joints}
    parents = {joint.child: joint.parent for joint in robot.joints}
    order = {link.name: number for number, link in enumerate(robot.links)}
    made: dict[str, tuple[Coordinate, ...]] = {}

    def side(links: Sequence[str]) -> tuple[Coordinate, ...]:
        for joint in (above[link] for link in links if link not in made):
            start = poses[joint.parent] @ joint.parent_from_joint
            made[joint.child] = tuple(_coordinates(joint.dofs, start))
        return tuple(one for link in reversed(links) for one in made[link])

    rings = []
    for loop in sorted(robot.loops, key=lambda one: one.name):
        to_a, to_b = ways_up(loop.link_a, loop.link_b, parents, order)
        own = tuple(_coordinates(loop.dofs, poses[loop.link_b] @ loop.b_from_frame))
        point = (poses[loop.link_a] @ loop.a_from_frame)[:3, 3]
        rings.append(_Ring(loop, side(to_a), side(to_b), own, point))
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


def _shares(robot: Robot) -> Mapping[str, Share]:
    """The share of every dof of a relation, drivers included."""
    slides = {dof.name for dof in robot.dofs if dof.kind == "slide"}
    found = {one.driver: Share(one.driver, 1.0, 0) for one in robot.relations}
    for one in robot.relations:
        power = (one.driver in slides) - (one.follower in slides)
        found[one.follower] = Share(one.driver, one.multiplier, power)
    return found


def _stacked(
    rings: Sequence[_Ring], shares: Mapping[str, Share]
) -> tuple[list[Array], Mapping[Coordinate, int]]:
    """The rows of each loop, and the column of each coordinate.

    What relations tie together has one column, scaled to a length of 1 over its coordinates: so that
    gears of whatever ratio leave all entries at about 1.
    """
    reach = _reach(rings)
    numbers: dict[object, int] = {}
    columns: dict[Coordinate, int] = {}
    factors: dict[Coordinate, float] = {}
    for one in dict.fromkeys(one for ring in rings for one in ring.way):
        share = shares.get(one.dof)
        columns[one] = numbers.setdefault(share.driver if share else one, len(numbers))
        factors[one] = share.multiplier * reach**share.power if share else 1.0
    lengths = np.zeros(len(numbers))
    for one, column in columns.items():
        lengths[column] = math.hypot(lengths[column], factors[one])
    blocks = []
    for ring in rings:
        block = np.zeros((6, len(numbers)))
        if ring.way:
            at = [columns[one] for one in ring.way]
            signs = np.repeat([1.0, -1.0], [len(ring.to_a), len(ring.to_b)])
            parts = signs * [factors[one] for one in ring.way] / lengths[at]
            np.add.at(block.T, at, (parts * _twists(ring.way, ring.point, reach)).T)
        blocks.append(_independent(_locked(ring, reach) @ block))
    return blocks, columns


def _twists(coordinates: Sequence[Coordinate], point: Array, reach: float) -> Array:
    """(6, n): of each, the angular velocity and that of `point` (3,) measured by `reach` [m]. A slide's
    rate is measured so too."""
    spins = np.array([one.spin for one in coordinates])
    arms = point - np.array([one.at for one in coordinates])
    shifts = np.array([one.shift for one in coordinates]) + np.cross(spins, arms)
    shifts[spins.any(axis=1)] /= reach
    return np.hstack([spins, shifts]).T


def _reach(rings: Sequence[_Ring]) -> float:
    """The largest distance [m] of a coordinate from the point of a loop that it is in; 1 without any."""
    ways = [np.array([one.at for one in ring.way]) - ring.point for ring in rings if ring.way]
    far = [float(np.linalg.norm(arms, axis=1).max()) for arms in ways]
    return max(far, default=0.0) or 1.0


def _locked(ring: _Ring, reach: float) -> Array:
    """(6 − f, 6): an orthonormal basis of the twists that the loop's own dofs do not let through."""
    if not ring.own:
        return np.eye(6)
    free = _twists(ring.own, ring.point, reach)
    basis: Array = np.linalg.svd(free)[0][:, free.shape[1] :].T
    return basis


def _independent(rows: Array) -> Array:
    """Independent rows with the same row space as `rows`."""
    if not rows.size:
        return rows[:0]
    _, sizes, across = np.linalg.svd(rows, full_matrices=False)
    rank = _count(sizes)
    independent: Array = sizes[:rank, None] * across[:rank]
    return independent


def _count(sizes: Array) -> int:
    """The rank, by singular values from the largest down."""
    # Conditions that a plane fulfils are all rounding: measured by the largest they would count.
    return int((sizes > RANK_TOLERANCE * max(1.0, float(sizes[0]))).sum()) if sizes.size else 0


def _solved(matrix: Array) -> tuple[int, NDArray[np.bool_]]:
    """The rank, and whether the conditions let each of n coordinates move (n,)."""
    if not matrix.size:
        return 0, np.ones(matrix.shape[1], dtype=bool)
    _, sizes, across = np.linalg.svd(matrix)
    rank = _count(sizes)
    return rank, (np.abs(across[rank:]) > RANK_TOLERANCE).any(axis=0)


def _added(blocks: Sequence[Array], before: int, whole: int, above: Sequence[Array] = ()) -> list[int]:
    """What each block of independent rows adds to the rank of those before it.

    `before` is the rank of the blocks `above`, `whole` with all of `blocks`. Halved until it is plain:
    a rank for every block would be work of the fourth power of their number.
    """
    most = [len(block) for block in blocks]
    if whole == before or whole - before == sum(most):
        return [0] * len(blocks) if whole == before else most
    if len(blocks) == 1:
        return [whole - before]
    half = len(blocks) // 2
    first, second = blocks[:half], blocks[half:]
    rank = _count(np.linalg.svd(np.vstack([*above, *first]), compute_uv=False))
    between = min(max(rank, before), whole)  # where a singular value is on the edge of counting
    return _added(first, before, between, above) + _added(second, between, whole, [*above, *first])


def _report_rigid(
    rings: Sequence[_Ring], moving: NDArray[np.bool_], columns: Mapping[Coordinate, int], log: Diagnostics
) -> None:
    for ring in rings:
        if ring.way and not any(moving[columns[one]] for one in ring.way):
            names = dict.fromkeys(one.dof for one in ring.way)
            text = f"the loop leaves no motion to {', '.join(names)}"
            hint = (
                "remove a mate or a relation of the loop, or FASTEN the links if they are meant to be rigid"
            )
            log.report("W-RIGID-LOOP", text, ring.loop.name, hint)
