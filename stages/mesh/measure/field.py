"""How far places are outside of a part, on a grid over it: worked out once, and then read off for thousands
of hulls."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points
from linkwright.stages.mesh.measure import Target, even, outside_part

_PITCH = 0.5
"""Between the nodes of the grid, in tolerances."""

_MOST_NODES = 3_000_000

_WALL = 0.9
"""What is nearer to the part than so many tolerances parts its inside from its outside: more than half the
distance of the points that stand for it."""

_SPACING = 0.4
"""Between the points that stand for the part, in tolerances, so that a wall of them has no gap."""

_MOST_POINTS = 300_000

_ASKED = 25
"""Nodes of a region that tell whether it is inside; where they differ, each of its nodes is asked."""

_FARTHEST = 10.0
"""What is further out is as bad, in tolerances: well beyond what is ever allowed."""


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """The distance from a part at each node of a grid, in tolerances, 0 inside: the nodes are `pitch` [m]
    apart from `low` on. Of a part so large that the grid would be, nothing is known beforehand."""

    target: Target
    tolerance: float
    pitch: float
    low: Points
    values: npt.NDArray[np.float32] | None

    @staticmethod
    def of(target: Target, tolerance: float) -> Field:
        """Of a part, for distances of some times the tolerance [m], to about a tenth of it."""
        # Late: a part from the cache needs no library that makes colliders or decimates.
        from scipy.ndimage import distance_transform_edt

        pitch = _PITCH * tolerance
        low, high = target.surface.vertices.min(axis=0) - 2 * pitch, target.surface.vertices.max(axis=0)
        shape = np.ceil((high - low) / pitch).astype(np.int64) + 3
        if np.prod(shape.astype(np.float64)) > _MOST_NODES:
            return Field(target, tolerance, pitch, low, None)
        count = 2 * target.surface.area() / (_SPACING * tolerance) ** 2
        samples = even(target.tree.corners, int(np.clip(count, 100, _MOST_POINTS))).points
        points = np.concatenate([target.surface.vertices, samples])
        flat = np.ravel_multi_index(tuple(np.rint((points - low) / pitch).astype(np.int64).T), shape)
        # Of the points of a cell the first stands for them.
        there, first = np.unique(flat, return_index=True)
        empty = np.ones(shape, dtype=bool)
        empty.ravel()[there] = False
        nearest = distance_transform_edt(empty, return_distances=False, return_indices=True)
        which = np.searchsorted(there, np.ravel_multi_index(tuple(nearest.reshape(3, -1)), shape))
        nodes = low + pitch * np.indices(shape).reshape(3, -1).T
        away = np.linalg.norm(nodes - points[first[which]], axis=1).reshape(shape) / tolerance
        away[_within(away > _WALL, nodes, target)] = 0.0
        return Field(target, tolerance, pitch, low, np.minimum(away, _FARTHEST).astype(np.float32))

    def __call__(self, points: Points) -> npt.NDArray[np.float64]:
        """(n,): the distance at points (n, 3), in tolerances, at most 10; beyond the grid that of its
        border."""
        if self.values is None:
            far, exact = outside_part(self.target, points, self.tolerance / 2)
            return np.minimum(np.where(exact, far, 0.0) / self.tolerance, _FARTHEST)
        # Late: a part from the cache needs no library that makes colliders or decimates.
        from scipy.ndimage import map_coordinates

        places = ((points - self.low) / self.pitch).T
        read = map_coordinates(self.values, places, order=1, mode="nearest")
        return np.asarray(read, dtype=np.float64)


def _within(free: npt.NDArray[np.bool_], nodes: Points, target: Target) -> npt.NDArray[np.bool_]:
    """Which of the nodes that are `free` of the surface are inside: all of a region are, or none."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.ndimage import label

    regions, count = label(free)
    flat = regions.ravel()
    order = np.argsort(flat, kind="stable")
    ends = np.searchsorted(flat[order], np.arange(1, count + 2))
    result = np.zeros(flat.shape, dtype=bool)
    for begin, end in itertools.pairwise(ends):
        members = order[begin:end]
        asked = target.inside(nodes[members[np.linspace(0, len(members) - 1, _ASKED).astype(np.int64)]])
        alike = asked.all() or not asked.any()
        result[members] = asked[0] if alike else target.inside(nodes[members])
    return np.asarray(result.reshape(free.shape))
