"""Which links never meet: apart in every one of many seeded poses, and by so much that what the poses
cannot have seen is apart too."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from linkwright.stages.export.urdf.srdf.convex import ConvexBodies, at_least
from linkwright.stages.robot.model.robot import Array, Configuration, Limits, Robot
from linkwright.stages.robot.motion.adjacency import Pair
from linkwright.stages.robot.motion.pose_batch import count_of, many_link_poses
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.tree_paths import ways_up

POSES = 512
"""Poses in which a pair has to be apart."""

MARGIN = 1e-3
"""What has to remain of the distance [m] beyond the poses that were looked at."""

REACH = 1.0
"""How far a slide without limits goes to either side [m], as in the URDF."""

_LEAST = POSES // 4
"""With fewer poses whose loops close nothing is known."""

_FEW = 6
"""With more dofs between two links so many poses say too little, unless balls around them stay apart."""

_NEAREST = 32
"""The poses whose distances tell how near other poses may come."""

_FIRST = 8
_AT_ONCE = 64
_MOST = 256
"""Poses of one pair whose distance is worked out, at a time and at most: a pair that needs more counts as one
that may meet."""


def apart(
    robot: Robot, start: Configuration, bodies: Mapping[str, ConvexBodies], known: Collection[Pair]
) -> tuple[Pair, ...]:
    """The pairs of links, none of them `known`, that never meet, in the order of the links. `start`: a pose
    in which the loops are closed; `bodies`: the colliders of those links that have any.

    Where the distance of two links grows from its least value at the end of ranges, the n-th least of N
    values over k dofs is (n / N)^(1/k) of the way: the least one that N poses cannot have seen lies
    (d_n - d_1) / (n^(1/k) - 1) below the least one seen. A minimum within the ranges is flatter.
    """
    robot = _as_read(robot)
    order = [link.name for link in robot.links if link.name in bodies]
    counts = _Between(robot)
    pairs = [(pair, counts.of(*pair)) for pair in combinations(order, 2) if pair not in known]
    pairs = [(pair, count) for pair, count in pairs if count]
    if not pairs:
        return ()
    values = sampled_poses(robot, POSES, REACH, start)
    if robot.dofs and count_of(values) < _LEAST:
        return ()
    poses = many_link_poses(robot, values)
    middles = {link: poses[link][:, :3, :3] @ bodies[link].middle + poses[link][:, :3, 3] for link in order}
    return tuple(
        pair
        for pair, count in pairs
        if _never(
            bodies[pair[0]],
            bodies[pair[1]],
            poses[pair[0]],
            poses[pair[1]],
            np.linalg.norm(middles[pair[0]] - middles[pair[1]], axis=1),
            count,
        )
    )


def _never(
    one: ConvexBodies, other: ConvexBodies, first: Array, second: Array, between: Array, count: int
) -> bool:
    """Whether two links at the poses `first` and `second` (n, 4, 4), whose balls' middles are that far
    apart (n,), with so many dofs between them, never meet."""
    least = between - one.reach - other.reach
    if _beyond(least, count) > MARGIN:
        return True
    if count > _FEW:
        return False
    worked_out = np.zeros(len(least), dtype=bool)
    while not worked_out[np.argsort(least, kind="stable")[:_NEAREST]].all():
        first_time = not worked_out.any()
        rows = np.argsort(np.where(worked_out, np.inf, least), kind="stable")
        rows = rows[: _FIRST if first_time else _AT_ONCE]
        rows = rows[~worked_out[rows]]
        found = at_least(one, other, _relative(first[rows], second[rows]), MARGIN)
        least[rows] = np.maximum(least[rows], found)
        worked_out[rows] = True
        # What is worked out stays, and the rest only grows.
        if _beyond(least, count, float(least[worked_out].min())) <= MARGIN or worked_out.sum() >= _MOST:
            return False
        if first_time and one.box is not None and other.box is not None:
            rest = np.flatnonzero(~worked_out)
            boxes = at_least(one.box, other.box, _relative(first[rest], second[rest]), -np.inf)
            least[rest] = np.maximum(least[rest], boxes)
    return _beyond(least, count) > MARGIN


def _beyond(least: Array, count: int, nearest: float | None = None) -> float:
    """The least distance [m] that is to be expected in all poses, of links with so many dofs between them,
    from those in some; `nearest`: the least of these, unless it is among them."""
    found = np.partition(least, _NEAREST - 1)[:_NEAREST]
    first, last = float(found.min()) if nearest is None else nearest, float(found.max())
    unseen: float = (last - first) / (float(_NEAREST) ** (1.0 / count) - 1.0)
    return first - unseen


def _relative(first: Array, second: Array) -> Array:
    """first_from_second (n, 4, 4)."""
    turns = np.swapaxes(first[:, :3, :3], 1, 2)
    out = np.tile(np.eye(4), (len(first), 1, 1))
    out[:, :3, :3] = turns @ second[:, :3, :3]
    out[:, :3, 3] = np.einsum("nij,nj->ni", turns, second[:, :3, 3] - first[:, :3, 3])
    return out


def _as_read(robot: Robot) -> Robot:
    """The robot as a reader of its URDF moves it: its balls tilt freely, and limits of followers hold up
    nothing."""
    followers = {one.follower for one in robot.relations}
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


class _Between:
    """How many dofs move links against each other."""

    def __init__(self, robot: Robot) -> None:
        self._parents = {joint.child: joint.parent for joint in robot.joints}
        self._order = {link.name: number for number, link in enumerate(robot.links)}
        drivers = {one.follower: one.driver for one in robot.relations}
        self._free = {joint.child for joint in robot.joints if joint.type == "free"}
        self._dofs = {
            joint.child: [
                f"{drivers.get(dof.name, dof.name)}/{turn}"
                for dof in joint.dofs
                for turn in range(3 if dof.kind == "ball" else 1)
            ]
            for joint in robot.joints
        }

    def of(self, one: str, other: str) -> int:
        """0 where a free joint is between them: what flies may go anywhere."""
        links: Iterator[str] = (
            link for way in ways_up(one, other, self._parents, self._order) for link in way
        )
        moved: set[str] = set()
        for link in links:
            if link in self._free:
                return 0
            moved |= set(self._dofs[link])
        return len(moved)
