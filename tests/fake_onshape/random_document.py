"""Random documents for property tests: `documents()` is a hypothesis strategy.

Structure (who hangs on whom, by what, in which order) is drawn, so that it shrinks; lengths, frames
and values come from one drawn seed.
"""

import numpy as np
from hypothesis import strategies as st

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import turn

MOST_PARTS = 14


@st.composite
def documents(draw, max_bodies=12, depth=3, gears=True, loops=False, fixed=None, everything=False):
    """A document with 2..`max_bodies` bodies in one tree, and sub-assemblies `depth` deep at most.

    `gears`: up to two gear relations. `loops`: up to two closing REVOLUTE mates that are met at the
    saved pose. `fixed`: True: a part of the root assembly is fixed, False: none is, None: drawn.
    The saved values are at most 1.2 rad (2.4 behind a gear) or 0.2 m and within the limits; gears
    hold without an offset.

    `everything`: all that an assembly can hold (`random_everything`), one level deeper, and copies of
    patterns and mirrors beyond `max_bodies`.
    """
    from tests.fake_onshape.random_everything import Everything

    return Everything(draw, max_bodies, depth + everything, everything).write(gears, loops, fixed)


class Author:
    """Draws what has no structure: parts, frames and limits."""

    def __init__(self, draw, max_bodies, depth):
        self.draw, self.depth = draw, depth
        self.joints_left, self.parts_left = max_bodies - 1, MOST_PARTS
        self.rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1), label="seed"))
        self.document = Document("Random")
        self.made = []
        self.parts = self._parts()

    def _parts(self):
        homes = [self.document]
        if self.draw(st.booleans(), label="linked"):
            homes.append(self.document.library("Library"))
        parts = []
        for index in range(self.draw(st.integers(1, 4), label="parts")):
            home = homes[index % len(homes)]
            studio = (
                home.studio(f"Studio {index}") if index < len(homes) else parts[index % len(homes)].studio
            )
            if self.rng.random() < 0.5:
                solid = solids.box(*self.rng.uniform(0.02, 0.2, 3), at=self.rng.uniform(-0.1, 0.1, 3))
            else:
                outline = outlines.circle(self.rng.uniform(0.02, 0.1), self.rng.uniform(-0.1, 0.1, 2), 5)
                solid = solids.extrude(outline, self.rng.uniform(0.02, 0.2))
            colour = tuple(int(part) for part in self.rng.integers(0, 256, 3))
            parts.append(studio.part(f"Part {index + 1}", solid, float(self.rng.uniform(500, 8000)), colour))
        return parts

    def _limits(self, kind):
        # Wider than any saved value: Onshape holds a mate within its limits.
        reach, more = (2.45, 0.6) if kind == "REVOLUTE" else (0.21, 0.2)
        low, high = (float(sign * (reach + more * self.rng.random())) for sign in (-1, 1))
        return [(low, high), (low, high), (low, None), (None, high), (None, None)][self.rng.integers(5)]

    def _frame(self):
        axis = self.rng.normal(size=3)
        return turn(
            axis / np.sqrt(np.sum(axis * axis)),
            float(self.rng.uniform(-3, 3)),
            self.rng.uniform(-0.3, 0.3, 3),
        )


def touching(truth, first, second):
    """Whether two parts are of one body, or of two that a mate joins: there another one closes no loop
    but takes away motion."""
    weld = {path: number for number, paths in enumerate(truth.tree.welds()) for path in paths}
    pairs = [{weld[edge.first], weld[edge.second]} for edge in truth.joints]
    return weld[first] == weld[second] or {weld[first], weld[second]} in pairs
