"""Finds links that never meet: they are apart in each of many seeded poses, with a margin for the poses
between."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from linkwright.stages.export.urdf.srdf.convex import ConvexBodies, distance_bounds
from linkwright.stages.robot.model.robot import Array, Configuration, Limits, Robot
from linkwright.stages.robot.motion.adjacency import Pair
from linkwright.stages.robot.motion.pose_batch import count_of, many_link_poses
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.tree_paths import paths_up

POSE_COUNT = 512
"""Number of poses in which a pair has to be apart."""

MIN_DISTANCE = 1e-3
"""Distance [m] that must remain between two links in the poses between the sampled ones."""

SLIDE_REACH = 1.0
"""Range of a slide without limits to either side [m], as in the URDF."""

_MIN_POSES = POSE_COUNT // 4
"""Smallest number of poses with closed loops from which anything is concluded."""

_MAX_DOFS = 6
"""Largest number of dofs between two links for which the sampled poses suffice. Links with more dofs between
them count only if the balls around them stay apart."""

_NEAREST_COUNT = 32
"""Number of the poses with the smallest distances, from which the distance in other poses is extrapolated."""

_FIRST_BATCH_SIZE = 8
"""Number of poses of a pair whose distances are computed first."""

_BATCH_SIZE = 64
"""Number of poses of a pair whose distances are computed at once after the first."""

_MAX_COMPUTED = 256
"""Largest number of poses of a pair whose distances are computed: a pair that needs more may meet."""


def never_meeting(
    robot: Robot, start: Configuration, bodies: Mapping[str, ConvexBodies], excluded_pairs: Collection[Pair]
) -> tuple[Pair, ...]:
    """Returns the pairs of links that never meet, without `excluded_pairs`, in the order of the links.
    `start`: a pose in which the loops are closed; `bodies`: the colliders of the links that have some.

    If the distance of two links grows from its minimum at the end of ranges, the n-th smallest of N values
    over k dofs is (n / N)^(1/k) of the way. The smallest distance that N poses cannot have seen then lies
    (d_n - d_1) / (n^(1/k) - 1) below the smallest seen. A minimum within the ranges is flatter.
    """
    robot = _as_read_from_urdf(robot)
    order = [link.name for link in robot.links if link.name in bodies]
    counts = _DofCounts(robot)
    pairs = [(pair, counts.between(*pair)) for pair in combinations(order, 2) if pair not in excluded_pairs]
    pairs = [(pair, count) for pair, count in pairs if count]
    if not pairs:
        return ()
    values = sampled_poses(robot, POSE_COUNT, SLIDE_REACH, start)
    if robot.dofs and count_of(values) < _MIN_POSES:
        return ()
    poses = many_link_poses(robot, values)
    middles = {link: poses[link][:, :3, :3] @ bodies[link].middle + poses[link][:, :3, 3] for link in order}
    return tuple(
        pair
        for pair, count in pairs
        if _never_meet(
            bodies[pair[0]],
            bodies[pair[1]],
            poses[pair[0]],
            poses[pair[1]],
            np.linalg.norm(middles[pair[0]] - middles[pair[1]], axis=1),
            count,
        )
    )


def _never_meet(
    first_bodies: ConvexBodies,
    second_bodies: ConvexBodies,
    first_poses: Array,
    second_poses: Array,
    middle_distances: Array,
    dof_count: int,
) -> bool:
    """Tells whether two links never meet. `first_poses`, `second_poses` (n, 4, 4); `middle_distances` (n,):
    the distances [m] of the middles of the balls around them; `dof_count`: the number of dofs between
    them."""
    # Lower bounds of the distances, which are replaced by better bounds for the nearest poses.
    distances = middle_distances - first_bodies.reach - second_bodies.reach
    if _extrapolated_distance(distances, dof_count) > MIN_DISTANCE:
        return True
    if dof_count > _MAX_DOFS:
        return False
    computed = np.zeros(len(distances), dtype=bool)
    while not computed[np.argsort(distances, kind="stable")[:_NEAREST_COUNT]].all():
        is_first = not computed.any()
        rows = np.argsort(np.where(computed, np.inf, distances), kind="stable")
        rows = rows[: _FIRST_BATCH_SIZE if is_first else _BATCH_SIZE]
        rows = rows[~computed[rows]]
        bounds = distance_bounds(
            first_bodies, second_bodies, _relative(first_poses[rows], second_poses[rows]), MIN_DISTANCE
        )
        distances[rows] = np.maximum(distances[rows], bounds)
        computed[rows] = True
        # Computed distances stay, and the bounds of the others only grow.
        if (
            _extrapolated_distance(distances, dof_count, float(distances[computed].min())) <= MIN_DISTANCE
            or computed.sum() >= _MAX_COMPUTED
        ):
            return False
        if is_first and first_bodies.box is not None and second_bodies.box is not None:
            uncomputed = np.flatnonzero(~computed)
            boxes = distance_bounds(
                first_bodies.box,
                second_bodies.box,
                _relative(first_poses[uncomputed], second_poses[uncomputed]),
                -np.inf,
            )
            distances[uncomputed] = np.maximum(distances[uncomputed], boxes)
    return _extrapolated_distance(distances, dof_count) > MIN_DISTANCE


def _extrapolated_distance(distances: Array, dof_count: int, nearest: float | None = None) -> float:
    """Returns the smallest distance [m] to expect in all poses, from the distances in the sampled ones.
    `dof_count`: the number of dofs between the links; `nearest`: the smallest distance, by default that in
    `distances`."""
    smallest = np.partition(distances, _NEAREST_COUNT - 1)[:_NEAREST_COUNT]
    first, last = float(smallest.min()) if nearest is None else nearest, float(smallest.max())
    # The distance by which a pose between the sampled ones may be nearer: see `never_meeting`.
    unseen: float = (last - first) / (float(_NEAREST_COUNT) ** (1.0 / dof_count) - 1.0)
    return first - unseen


def _relative(first: Array, second: Array) -> Array:
    """Returns first_from_second (n, 4, 4) from the poses (n, 4, 4) of both links."""
    turns = np.swapaxes(first[:, :3, :3], 1, 2)
    first_from_second = np.tile(np.eye(4), (len(first), 1, 1))
    first_from_second[:, :3, :3] = turns @ second[:, :3, :3]
    first_from_second[:, :3, 3] = np.einsum("nij,nj->ni", turns, second[:, :3, 3] - first[:, :3, 3])
    return first_from_second


def _as_read_from_urdf(robot: Robot) -> Robot:
    """Returns the robot as a reader of its URDF moves it: balls tilt freely, and limits of followers stop
    nothing."""
    followers = {relation.follower for relation in robot.relations}
    joints = tuple(
        replace(
            joint,
            dofs=tuple(
                replace(dof, limits=Limits()) if dof.kind == "ball" or dof.name in followers else dof
                for dof in joint.dofs
            ),
        )
        for joint in robot.joints
    )
    return replace(robot, joints=joints)


class _DofCounts:
    """The numbers of independent dofs between any two links: a follower counts as its driver, a ball as three
    dofs."""

    def __init__(self, robot: Robot) -> None:
        self._parents = {joint.child: joint.parent for joint in robot.joints}
        self._order = {link.name: index for index, link in enumerate(robot.links)}
        # Each dof has an identifier: that of its driver if it follows one, and a number for the turns of a
        # ball.
        drivers = {relation.follower: relation.driver for relation in robot.relations}
        self._free = {joint.child for joint in robot.joints if joint.type == "free"}
        self._dofs = {
            joint.child: [
                f"{drivers.get(dof.name, dof.name)}/{turn}"
                for dof in joint.dofs
                for turn in range(3 if dof.kind == "ball" else 1)
            ]
            for joint in robot.joints
        }

    def between(self, first: str, second: str) -> int:
        """Returns the number of dofs between two links; 0 if a free joint is between them, which
        leaves them free to meet."""
        links: Iterator[str] = (
            link for path in paths_up(first, second, self._parents, self._order) for link in path
        )
        dofs: set[str] = set()
        for link in links:
            if link in self._free:
                return 0
            dofs |= set(self._dofs[link])
        return len(dofs)
