"""Computes the mobility of a mechanism: the number of its coordinates less the rank of the conditions of its
relations and loops.

A loop requires that the twist of its frame along the path to link a equals that along the path to link b,
except for the motions of its own dofs: 6 − f rows over the coordinates on both paths (Angeles, "Fundamentals
of Robotic Mechanical Systems", on the rank of the Jacobian of a closed chain). Lengths are measured by the
reach of connected loops, so that all entries are about 1.

The rank is that at the saved pose: where the pose is singular (a flat parallelogram, with all its pivots in
line) it is lower than elsewhere, and `dof` counts motions that neighbouring poses do not have.
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
from linkwright.stages.robot.motion.tree_paths import paths_up

DOF_COUNTS = {"turn": 1, "slide": 1, "ball": 3, "free": 6}

RANK_TOLERANCE = 1e-6
"""Singular values below this count as zero: entries are about 1, and saved poses are exact to about 1e-8."""


@dataclass(frozen=True, slots=True, eq=False)
class Coordinate:
    """A scalar motion at the saved pose, in the root's frame, for a unit rate."""

    dof: str
    spin: Array
    """Angular velocity (3,)."""
    shift: Array
    """Velocity (3,) of the point `point_on_axis`."""
    point_on_axis: Array
    """A point (3,) on the axis; for a slide, any point."""


@dataclass(frozen=True, slots=True, eq=False)
class _Ring:
    """A loop with its coordinates."""

    loop: Loop
    on_path_a: tuple[Coordinate, ...]
    """Coordinates on the path to link a."""
    on_path_b: tuple[Coordinate, ...]
    """Coordinates on the path to link b."""
    closure: tuple[Coordinate, ...]
    """Coordinates of the loop's own dofs."""
    point: Array
    """Origin of the loop's frame on link a (3,)."""

    @property
    def on_both_paths(self) -> tuple[Coordinate, ...]:
        """The coordinates on both paths, without those of the loop's own dofs."""
        return self.on_path_a + self.on_path_b


@dataclass(frozen=True, slots=True)
class Share:
    """The rate of a dof relative to that of its driver: `multiplier`, times the reach to the `power`."""

    driver: str
    multiplier: float
    power: int
    """1 if only the driver is a slide, -1 if only the follower is, else 0: rates of slides count in units of
    the reach."""


def with_mobility(robot: Robot, log: Diagnostics) -> Robot:
    """Returns the robot with its mobility. Reports W-RIGID-LOOP for loops that lock their links.

    A loop's redundant conditions are those that follow from the relations and from the loops before it
    by name.
    """
    coordinates = sum(DOF_COUNTS[dof.kind] for dof in robot.dofs)
    conditions = len(robot.relations) + sum(_conditions(loop) for loop in robot.loops)
    # Relations are trees: none of them follows from others.
    rank, redundant = len(robot.relations), dict[str, int]()
    shares = _shares(robot)
    for rings in _groups(_rings(robot), shares):
        blocks, columns = _constraint_rows(rings, shares)
        total_rank, moving = _rank_and_motion(np.vstack(blocks))
        rank += total_rank
        for ring, added in zip(rings, _rank_increments(blocks, 0, total_rank), strict=True):
            redundant[ring.loop.name] = _conditions(ring.loop) - added
        _report_rigid(rings, moving, columns, log)
    redundancies = tuple((name, count) for name, count in sorted(redundant.items()) if count)
    return replace(
        robot, mobility=Mobility(coordinates, coordinates - conditions, coordinates - rank, redundancies)
    )


def _conditions(loop: Loop) -> int:
    return 6 - sum(DOF_COUNTS[dof.kind] for dof in loop.dofs)


def _groups(rings: Sequence[_Ring], shares: Mapping[str, Share]) -> list[list[_Ring]]:
    """Groups loops that share coordinates, by themselves or through relations, in the order of their
    names."""
    forest = nx.utils.UnionFind(range(len(rings)))
    first: dict[str, int] = {}
    for number, ring in enumerate(rings):
        for name in {
            shares[coordinate.dof].driver if coordinate.dof in shares else coordinate.dof
            for coordinate in ring.on_both_paths
        }:
            forest.union(number, first.setdefault(name, number))
    groups: dict[int, list[_Ring]] = {}
    for number, ring in enumerate(rings):
        groups.setdefault(forest[number], []).append(ring)
    return list(groups.values())


def _rings(robot: Robot) -> list[_Ring]:
    poses = link_poses(robot, saved_configuration(robot))
    joint_of = {joint.child: joint for joint in robot.joints}
    parents = {joint.child: joint.parent for joint in robot.joints}
    order = {link.name: number for number, link in enumerate(robot.links)}
    coordinates: dict[str, tuple[Coordinate, ...]] = {}

    def coordinates_on(links: Sequence[str]) -> tuple[Coordinate, ...]:
        for joint in (joint_of[link] for link in links if link not in coordinates):
            start = poses[joint.parent] @ joint.parent_from_joint
            coordinates[joint.child] = tuple(_coordinates(joint.dofs, start))
        return tuple(coordinate for link in reversed(links) for coordinate in coordinates[link])

    rings = []
    for loop in sorted(robot.loops, key=lambda loop: loop.name):
        on_path_a, on_path_b = paths_up(loop.link_a, loop.link_b, parents, order)
        closure = tuple(_coordinates(loop.dofs, poses[loop.link_b] @ loop.b_from_frame))
        point = (poses[loop.link_a] @ loop.a_from_frame)[:3, 3]
        rings.append(_Ring(loop, coordinates_on(on_path_a), coordinates_on(on_path_b), closure, point))
    return rings


def _coordinates(dofs: Iterable[Dof], root_from_start: Array) -> Iterator[Coordinate]:
    """Yields the scalar motions of a chain of dofs that starts at this pose (4, 4), at its saved values."""
    pose, zero = root_from_start, np.zeros(3)
    for dof in dofs:
        pose = pose @ dof.origin
        pose_after = pose @ motion(dof.kind, dof.axis, dof.saved)
        axis = pose[:3, :3] @ dof.axis
        if dof.kind == "turn":
            yield Coordinate(dof.name, axis, zero, pose[:3, 3])
        elif dof.kind == "slide":
            yield Coordinate(dof.name, zero, axis, pose[:3, 3])
        else:
            for spin_axis in pose_after[:3, :3].T:
                yield Coordinate(dof.name, spin_axis, zero, pose_after[:3, 3])
            for shift_axis in pose_after[:3, :3].T if dof.kind == "free" else ():
                yield Coordinate(dof.name, zero, shift_axis, pose_after[:3, 3])
        pose = pose_after


def _shares(robot: Robot) -> Mapping[str, Share]:
    """Returns the share of every dof of a relation, drivers included."""
    slides = {dof.name for dof in robot.dofs if dof.kind == "slide"}
    shares = {relation.driver: Share(relation.driver, 1.0, 0) for relation in robot.relations}
    for relation in robot.relations:
        power = (relation.driver in slides) - (relation.follower in slides)
        shares[relation.follower] = Share(relation.driver, relation.multiplier, power)
    return shares


def _constraint_rows(
    rings: Sequence[_Ring], shares: Mapping[str, Share]
) -> tuple[list[Array], Mapping[Coordinate, int]]:
    """Returns the rows of each loop, and the column of each coordinate.

    Coordinates that relations couple share a column, scaled to a length of 1 over its coordinates: so gears
    of any ratio leave all entries at about 1.
    """
    reach = _reach(rings)
    column_of_key: dict[object, int] = {}
    columns: dict[Coordinate, int] = {}
    factors: dict[Coordinate, float] = {}
    for coordinate in dict.fromkeys(coordinate for ring in rings for coordinate in ring.on_both_paths):
        share = shares.get(coordinate.dof)
        columns[coordinate] = column_of_key.setdefault(
            share.driver if share else coordinate, len(column_of_key)
        )
        factors[coordinate] = share.multiplier * reach**share.power if share else 1.0
    lengths = np.zeros(len(column_of_key))
    for coordinate, column in columns.items():
        lengths[column] = math.hypot(lengths[column], factors[coordinate])
    blocks = []
    for ring in rings:
        block = np.zeros((6, len(column_of_key)))
        if ring.on_both_paths:
            indices = [columns[coordinate] for coordinate in ring.on_both_paths]
            # The twists along both paths must be equal: their difference is zero.
            signs = np.repeat([1.0, -1.0], [len(ring.on_path_a), len(ring.on_path_b)])
            parts = signs * [factors[coordinate] for coordinate in ring.on_both_paths] / lengths[indices]
            np.add.at(block.T, indices, (parts * _twists(ring.on_both_paths, ring.point, reach)).T)
        blocks.append(_independent_rows(_locked_twists(ring, reach) @ block))
    return blocks, columns


def _twists(coordinates: Sequence[Coordinate], point: Array, reach: float) -> Array:
    """Returns the twists (6, n) of coordinates: the angular velocity, and the velocity of `point` (3,)
    measured by `reach` [m]. A slide's rate is measured by `reach` too."""
    spins = np.array([coordinate.spin for coordinate in coordinates])
    arms = point - np.array([coordinate.point_on_axis for coordinate in coordinates])
    shifts = np.array([coordinate.shift for coordinate in coordinates]) + np.cross(spins, arms)
    shifts[spins.any(axis=1)] /= reach
    return np.hstack([spins, shifts]).T


def _reach(rings: Sequence[_Ring]) -> float:
    """Returns the largest distance [m] of a coordinate from the point of its loop; 1 without coordinates."""
    offsets = [
        np.array([coordinate.point_on_axis for coordinate in ring.on_both_paths]) - ring.point
        for ring in rings
        if ring.on_both_paths
    ]
    distances = [float(np.linalg.norm(arms, axis=1).max()) for arms in offsets]
    return max(distances, default=0.0) or 1.0


def _locked_twists(ring: _Ring, reach: float) -> Array:
    """Returns an orthonormal basis (6 − f, 6) of the twists that the loop's own dofs do not allow."""
    if not ring.closure:
        return np.eye(6)
    # The left singular vectors behind those of the free twists are orthogonal to these.
    free_twists = _twists(ring.closure, ring.point, reach)
    basis: Array = np.linalg.svd(free_twists)[0][:, free_twists.shape[1] :].T
    return basis


def _independent_rows(rows: Array) -> Array:
    """Returns independent rows with the same row space as `rows`."""
    if not rows.size:
        return rows[:0]
    _, sizes, right_vectors = np.linalg.svd(rows, full_matrices=False)
    rank = _rank(sizes)
    # Of rows U S Vᵀ, the rows of S Vᵀ span the same space.
    independent: Array = sizes[:rank, None] * right_vectors[:rank]
    return independent


def _rank(sizes: Array) -> int:
    """Returns the rank of a matrix with these singular values, the largest first."""
    # The conditions that a planar loop fulfils by itself are all rounding: measured by the largest they would
    # count.
    return int((sizes > RANK_TOLERANCE * max(1.0, float(sizes[0]))).sum()) if sizes.size else 0


def _rank_and_motion(matrix: Array) -> tuple[int, NDArray[np.bool_]]:
    """Returns the rank, and whether the conditions let each of n coordinates move (n,)."""
    if not matrix.size:
        return 0, np.ones(matrix.shape[1], dtype=bool)
    _, sizes, right_vectors = np.linalg.svd(matrix)
    rank = _rank(sizes)
    # A coordinate moves if it has an entry in the null space, which the last rows of Vᵀ span.
    return rank, (np.abs(right_vectors[rank:]) > RANK_TOLERANCE).any(axis=0)


def _rank_increments(
    blocks: Sequence[Array], rank_above: int, total_rank: int, blocks_above: Sequence[Array] = ()
) -> list[int]:
    """Returns the rank that each block of independent rows adds to those before it.

    `rank_above` is the rank of the blocks `blocks_above`, `total_rank` the rank with all of `blocks`. The
    blocks are halved until the ranks are plain: a rank for every block would take work of the fourth power of
    their number.
    """
    sizes = [len(block) for block in blocks]
    if total_rank == rank_above or total_rank - rank_above == sum(sizes):
        return [0] * len(blocks) if total_rank == rank_above else sizes
    if len(blocks) == 1:
        return [total_rank - rank_above]
    half = len(blocks) // 2
    first, second = blocks[:half], blocks[half:]
    rank = _rank(np.linalg.svd(np.vstack([*blocks_above, *first]), compute_uv=False))
    rank_between = min(max(rank, rank_above), total_rank)  # where a singular value is on the edge of counting
    return _rank_increments(first, rank_above, rank_between, blocks_above) + _rank_increments(
        second, rank_between, total_rank, [*blocks_above, *first]
    )


def _report_rigid(
    rings: Sequence[_Ring], moving: NDArray[np.bool_], columns: Mapping[Coordinate, int], log: Diagnostics
) -> None:
    for ring in rings:
        if ring.on_both_paths and not any(moving[columns[coordinate]] for coordinate in ring.on_both_paths):
            names = dict.fromkeys(coordinate.dof for coordinate in ring.on_both_paths)
            text = f"the loop leaves no motion to {', '.join(names)}"
            hint = (
                "remove a mate or a relation of the loop, or FASTEN the links if they are meant to be rigid"
            )
            log.report("W-RIGID-LOOP", text, ring.loop.name, hint)
