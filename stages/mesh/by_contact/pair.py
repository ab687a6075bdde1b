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
class Pair:
    """Two links whose colliders may touch falsely, with the poses in which their hulls overlap although their
    meshes are apart."""

    one: int
    other: int
    """Indices of the links."""
    one_from_other: Array
    """Poses (n, 4, 4) of the second link relative to the first."""
    borne: Numbers
    """Depth (n,) [m] by which the colliders may overlap in each pose."""
    allowed: int
    """Largest number of poses in which they may overlap by more."""
    home: int
    """Row of the pose `home`, in which they may never overlap by more; -1 if it is not among the poses."""
    stuck: bool = False
    """Whether no cut improves the pair."""
    vain: int = 0
    """Number of cuts in a row that hardly improved the pair."""
    poses: Any = field(init=False)
    """The poses in the form of the collision engine."""
    _deeper: dict[tuple[Chunk, Chunk], Numbers] = field(default_factory=dict, init=False)
    """The excess depths (n,) of two pieces that `of_chunks` has computed."""

    def __post_init__(self) -> None:
        self.poses = engine().poses(self.one_from_other)

    def deeper(self, first: Any, second: Any, rows: npt.NDArray[np.int64]) -> Numbers:
        """Returns the excess depth (k,) [m] of two convex solids in the poses `rows`: how much deeper they
        overlap than `borne` allows, at least 0."""
        depth_of = engine().depth
        depths = [depth_of(first, second, self.poses[row]) for row in rows.tolist()]
        return np.maximum(np.array(depths, dtype=float) - self.borne[rows], 0.0)

    def of_chunks(self, first: Chunk, second: Chunk, within: Numbers | None = None) -> Numbers:
        """Returns the excess depths (n,) [m] of two pieces in all poses. `within` (n,): the excess depths of
        a piece of which one of the two is a part; where they are 0, so are the part's."""
        # `within` only saves time: the values are the same without it, so they are kept for any `within`.
        if (first, second) not in self._deeper:
            rows = np.arange(len(self.borne)) if within is None else np.flatnonzero(within)
            depths = np.zeros(len(self.borne))
            depths[rows] = self.deeper(first.convex, second.convex, rows)
            self._deeper[first, second] = depths
        return self._deeper[first, second]

    def false_at_home(self, deeper: Numbers) -> bool:
        """Tells whether the colliders touch falsely at `home`. `deeper` (n,): the excess depths of the
        pair."""
        return self.home >= 0 and bool(deeper[self.home] > 0)

    def badness(self, deeper: Numbers) -> int:
        """Returns the number of poses in which the colliders touch falsely, with a penalty for `home`, where
        that is never allowed."""
        return int(np.count_nonzero(deeper > 0)) + _HOME_PENALTY * self.false_at_home(deeper)
