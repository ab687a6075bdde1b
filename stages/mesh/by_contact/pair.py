"""Measures for two links that may be false how deep their pieces are in each other."""

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
"""Number that is larger than that of all poses."""


@dataclass(eq=False)
class Pair:
    """Two links that may be false, with the poses in which their meshes are apart and their hulls overlap."""

    one: int
    other: int
    """Indices of the links."""
    one_from_other: Array
    """Relative poses (n, 4, 4)."""
    borne: Numbers
    """Largest depth (n,) [m] by which the colliders may be in each other."""
    allowed: int
    """Largest number of poses in which the colliders may be deeper."""
    home: int
    """Row of the pose `home`, in which they may never be deeper; -1 if it is not among the poses."""
    stuck: bool = False
    """Whether no cut improves the pair."""
    vain: int = 0
    """Number of vain cuts in a row."""
    poses: Any = field(init=False)
    """The poses in the form of the collision engine."""
    _deeper: dict[tuple[Chunk, Chunk], Numbers] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        self.poses = engine().poses(self.one_from_other)

    def deeper(self, first: Any, second: Any, rows: npt.NDArray[np.int64]) -> Numbers:
        """Returns by how much [m] (k,) two convex solids are deeper in each other than `borne` allows, else
        0."""
        depth_of = engine().depth
        depths = [depth_of(first, second, self.poses[row]) for row in rows.tolist()]
        return np.maximum(np.array(depths, dtype=float) - self.borne[rows], 0.0)

    def of_chunks(self, first: Chunk, second: Chunk, within: Numbers | None = None) -> Numbers:
        """Returns `deeper` (n,) of two pieces in all poses; with `within`, only where that is more than 0."""
        if (first, second) not in self._deeper:
            rows = np.arange(len(self.borne)) if within is None else np.flatnonzero(within)
            depths = np.zeros(len(self.borne))
            depths[rows] = self.deeper(first.convex, second.convex, rows)
            self._deeper[first, second] = depths
        return self._deeper[first, second]

    def false_at_home(self, deeper: Numbers) -> bool:
        """Tells whether the pair is false at `home`."""
        return self.home >= 0 and bool(deeper[self.home] > 0)

    def badness(self, deeper: Numbers) -> int:
        """Returns the number of poses in which the pair is false, with a penalty for `home`, which is never
        allowed."""
        return int(np.count_nonzero(deeper > 0)) + _HOME_PENALTY * self.false_at_home(deeper)
