"""How far places are outside of a part, on a grid over it: worked out once, and then read off for thousands
of hulls."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stages.mesh.surface import Points

_PITCH = 0.5
"""Between the nodes of the grid, in tolerances."""

_MOST_NODES = 3_000_000

_WALL = 0.9
"""What is nearer to the part than so many tolerances parts its inside from its outside: more than half the
distance of the points that stand for it."""

_ASKED = 25
"""Nodes of a region that tell whether it is inside; where they differ, each of its nodes is asked."""


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """The distance [m] from a part at each node of a grid, 0 inside: the nodes are `pitch` [m] apart from
    `low` on."""

    low: Points
    pitch: float
    values: npt.NDArray[np.float32]

    @staticmethod
    def of(
        points: Points, inside: Callable[[Points], npt.NDArray[np.bool_]], tolerance: float
    ) -> Field | None:
        """Of the points (n, 3) that stand for a surface, and what is inside of it. None where the grid would
        be too large."""
        from scipy.ndimage import distance_transform_edt

        pitch = _PITCH * tolerance
        low = points.min(axis=0) - 2 * pitch
        shape = np.ceil((points.max(axis=0) - low) / pitch).astype(np.int64) + 3
        if np.prod(shape.astype(np.float64)) > _MOST_NODES:
            return None
        cells = np.rint((points - low) / pitch).astype(np.int64)
        flat = np.ravel_multi_index(tuple(cells.T), shape)
        # Of the points of a cell the first stands for them.
        there, first = np.unique(flat, return_index=True)
        empty = np.ones(shape, dtype=bool)
        empty.ravel()[there] = False
        nearest = distance_transform_edt(empty, return_distances=False, return_indices=True)
        which = np.searchsorted(there, np.ravel_multi_index(tuple(nearest.reshape(3, -1)), shape))
        nodes = low + pitch * np.indices(shape).reshape(3, -1).T
        away = np.linalg.norm(nodes - points[first[which]], axis=1).reshape(shape)
        away[_within(away > _WALL * tolerance, nodes, inside)] = 0.0
        return Field(low, pitch, away.astype(np.float32))

    def __call__(self, points: Points) -> npt.NDArray[np.float64]:
        """(n,): the distance [m] at points (n, 3), between the nodes by their weighted mean; beyond the grid
        that of its border."""
        from scipy.ndimage import map_coordinates

        places = ((points - self.low) / self.pitch).T
        read = map_coordinates(self.values, places, order=1, mode="nearest")
        return np.asarray(read, dtype=np.float64)


def _within(
    free: npt.NDArray[np.bool_], nodes: Points, inside: Callable[[Points], npt.NDArray[np.bool_]]
) -> npt.NDArray[np.bool_]:
    """Which of the nodes that are `free` of the surface are inside: all of a region are, or none."""
    from scipy.ndimage import label

    regions, count = label(free)
    flat = regions.ravel()
    order = np.argsort(flat, kind="stable")
    ends = np.searchsorted(flat[order], np.arange(1, count + 2))
    result = np.zeros(flat.shape, dtype=bool)
    for begin, end in itertools.pairwise(ends):
        members = order[begin:end]
        asked = inside(nodes[members[np.linspace(0, len(members) - 1, _ASKED).astype(np.int64)]])
        result[members] = asked[0] if asked.all() or not asked.any() else inside(nodes[members])
    return np.asarray(result.reshape(free.shape))
