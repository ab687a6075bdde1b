"""Two links that may be false, and how deep their pieces are in each other."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.mesh.cut.piece import Chunk
from linkwright.stages.robot.contact.clearance import engine
from linkwright.stages.robot.model.robot import Array

Numbers = npt.NDArray[np.float64]

_TOO_MANY = 1000
"""More poses than there are."""


@dataclass(eq=False)
class Pair:
    """Two links that may be false: in these poses their meshes are apart and their hulls overlap.

    `one_from_other` (n, 4, 4); `borne` (n,) [m]: how deep colliders may be in each other; `allowed`: in how
    many poses they may be deeper; `home`: the row in which they may never, -1 for none.
    """

    one: int
    other: int
    one_from_other: Array
    borne: Numbers
    allowed: int
    home: int
    stuck: bool = False
    vain: int = 0
    poses: Any = field(init=False)
    _deeper: dict[tuple[Chunk, Chunk], Numbers] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        self.poses = engine().poses(self.one_from_other)

    def deeper(self, one: Any, other: Any, rows: npt.NDArray[np.int64]) -> Numbers:
        """(k,): by how much [m] two convex solids are deeper in each other than is borne, 0 where not."""
        ask = engine().depth
        found = [ask(one, other, self.poses[row]) for row in rows.tolist()]
        return np.maximum(np.array(found, dtype=float) - self.borne[rows], 0.0)

    def of_chunks(self, one: Chunk, other: Chunk, within: Numbers | None = None) -> Numbers:
        """(n,): the same of two pieces; only where `within` is more than 0, if it is given."""
        if (one, other) not in self._deeper:
            rows = np.arange(len(self.borne)) if within is None else np.flatnonzero(within)
            found = np.zeros(len(self.borne))
            found[rows] = self.deeper(one.convex, other.convex, rows)
            self._deeper[one, other] = found
        return self._deeper[one, other]

    def false_at_home(self, deeper: Numbers) -> bool:
        """Whether the pair is false at `home`."""
        return self.home >= 0 and bool(deeper[self.home] > 0)

    def badness(self, deeper: Numbers) -> int:
        """In how many poses a pair is false; one that is false at `home` is never good enough."""
        return int(np.count_nonzero(deeper > 0)) + _TOO_MANY * self.false_at_home(deeper)
