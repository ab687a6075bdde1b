"""Measures how deep the colliders of two links overlap in poses in which the links' meshes are apart."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.mesh.cut.chunk import Chunk
from linkwright.stages.robot.contact.clearance import engine
from linkwright.stages.robot.model.robot import Array

Numbers = npt.NDArray[np.float64]

_HOME_PENALTY = 1000
"""Penalty for a false contact at `home`: more than the number of poses, so that it outweighs all of them."""


@dataclass(eq=False)
class LinkPair:
    """Two links whose colliders may touch falsely, with the poses in which their hulls overlap although their
    meshes are apart."""

    first_link: int
    second_link: int
    """Indices of the links."""
    first_from_second: Array
    """Poses (n, 4, 4) of the second link relative to the first."""
    allowed_depths: Numbers
    """Depth (n,) [m] by which the colliders may overlap in each pose."""
    max_false_poses: int
    """Largest number of poses in which they may overlap by more."""
    home_row: int
    """Row of the pose `home`, in which they may never overlap by more; -1 if it is not among the poses."""
    is_stuck: bool = False
    """Whether no cut improves the pair."""
    vain_cuts: int = 0
    """Number of cuts in a row that hardly improved the pair."""
    poses: Any = field(init=False)
    """The poses in the form of the collision engine."""
    _excess_by_chunks: dict[tuple[Chunk, Chunk], Numbers] = field(default_factory=dict, init=False)
    """The excess depths (n,) of two pieces that `chunk_excess_depths` has computed."""

    def __post_init__(self) -> None:
        self.poses = engine().poses(self.first_from_second)

    def excess_depths(self, first: Any, second: Any, rows: npt.NDArray[np.int64]) -> Numbers:
        """Returns the excess depth (k,) [m] of two convex solids in the poses `rows`: how much deeper they
        overlap than `allowed_depths` allows, at least 0."""
        depth_of = engine().depth
        depths = [depth_of(first, second, self.poses[row]) for row in rows.tolist()]
        return np.maximum(np.array(depths, dtype=float) - self.allowed_depths[rows], 0.0)

    def chunk_excess_depths(self, first: Chunk, second: Chunk, within: Numbers | None = None) -> Numbers:
        """Returns the excess depths (n,) [m] of two pieces in all poses. `within` (n,): the excess depths of
        a piece of which one of the two is a part; where they are 0, so are the part's."""
        # `within` only saves time: the values are the same without it, so they are kept for any `within`.
        if (first, second) not in self._excess_by_chunks:
            rows = np.arange(len(self.allowed_depths)) if within is None else np.flatnonzero(within)
            depths = np.zeros(len(self.allowed_depths))
            depths[rows] = self.excess_depths(first.engine_solid, second.engine_solid, rows)
            self._excess_by_chunks[first, second] = depths
        return self._excess_by_chunks[first, second]

    def false_at_home(self, excess_depths: Numbers) -> bool:
        """Tells whether the colliders touch falsely at `home`. `excess_depths` (n,): the excess depths of the
        pair."""
        return self.home_row >= 0 and bool(excess_depths[self.home_row] > 0)

    def badness(self, excess_depths: Numbers) -> int:
        """Returns the number of poses in which the colliders touch falsely, with a penalty for `home`, where
        that is never allowed."""
        return int(np.count_nonzero(excess_depths > 0)) + _HOME_PENALTY * self.false_at_home(excess_depths)
