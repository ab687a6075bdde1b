"""Random documents for property tests: `documents()` is a hypothesis strategy.

Structure (who hangs on whom, by what, in which order) is drawn, so that it shrinks; lengths, frames
and values come from one drawn seed.
"""

import numpy as np
from hypothesis import strategies as st

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.document import ORIGIN, Document
from tests.fake_onshape.frames import inverse, product, turn
from tests.fake_onshape.mates import motion

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
    if everything:
        from tests.fake_onshape.random_everything import Everything

        return Everything(draw, max_bodies, depth + 1).write(gears, loops, fixed)
    return Author(draw, max_bodies, depth).write(
        gears, loops, draw(st.booleans()) if fixed is None else fixed
    )


class Author:
    def __init__(self, draw, max_bodies, depth):
        self.draw, self.depth = draw, depth
        self.joints_left, self.parts_left = max_bodies - 1, MOST_PARTS
        self.rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1), label="seed"))
        self.document = Document("Random")
        self.made = []  # (assembly, its parts' occurrences, its moving mates' (owner, mate), its depth)
        self.parts = self._parts()

    def write(self, gears, loops, fixed):
        # The root is the document's first assembly, but its parts must exist before it.
        occurrences, mates = self._assembly("Robot", self.depth, fixed)
        self.document.root = self.made[-1][0]
        for owner, mate in mates:
            self.document.set_value(owner, mate, self._value(mate.type))
        if gears:
            self._gears(mates)
        if loops:
            self._loops(occurrences)
        self.document.truth.check()
        return self.document

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

    def _assembly(self, name, depth, fixed=False):
        """Build one assembly; returns its parts' occurrences and its moving (owner, mate)s."""
        nodes = []  # (occurrences of parts, moving mates) of each instance
        plan = []
        for index in range(self.draw(st.integers(2, 4), label="instances")):
            if index and self.parts_left <= 0:
                break
            nested = bool(index and depth > 1) and self.draw(st.booleans(), label="nested")
            plan.append(self._pick(depth) if nested else None)
            self.parts_left -= 0 if plan[-1] else 1
        assembly = self.document.assembly(f"{name} {len(self.made) + 1}")
        holder = self.draw(st.integers(0, len(plan) - 1), label="fixed") if fixed else 0
        holder = holder if plan[holder] is None else 0
        for index, nested in enumerate(plan):
            source = nested[0] if nested else self.draw(st.sampled_from(self.parts), label="part")
            held = fixed and index == holder
            pose = self._frame() if held or index == 0 else None
            at = assembly.add(source, fixed=held, pose=pose, hidden=bool(self.rng.random() < 0.1))
            if nested:
                nodes.append(
                    ([at / part for part in nested[1]], [(at / owner, mate) for owner, mate in nested[2]])
                )
            else:
                nodes.append(([at], []))
            if index:
                last = depth == self.depth and index == len(plan) - 1
                self._mate(assembly, nodes, moves=last and not any(moving for _, moving in nodes))
        occurrences = [occurrence for parts, _ in nodes for occurrence in parts]
        mates = [mate for _, moving in nodes for mate in moving]
        assembly.ground(occurrences[self.rng.integers(len(occurrences))], self._frame())
        self.made.append((assembly, occurrences, mates, 1 + self.depth - depth))
        return occurrences, mates

    def _pick(self, depth):
        """A sub-assembly: one that exists already and fits, or a new one."""
        fits = [
            made
            for made in self.made
            if len(made[1]) <= self.parts_left
            and len(made[2]) <= self.joints_left
            and made[3] > 1 + self.depth - depth
        ]
        if fits and self.draw(st.booleans(), label="again"):
            again = self.draw(st.sampled_from(fits), label="which")
            self.parts_left -= len(again[1])
            self.joints_left -= len(again[2])
            return again
        self._assembly("Sub", depth - 1)
        return self.made[-1]

    def _mate(self, assembly, nodes, moves):
        """Hang the last node on one of those before it; `moves`: not by FASTENED."""
        parts, moving = nodes[-1]
        onto = self.draw(st.sampled_from([part for others, _ in nodes[:-1] for part in others]), label="onto")
        one = self.draw(st.sampled_from(parts), label="one")
        kinds = ["REVOLUTE", "REVOLUTE", "SLIDER", "FASTENED"] if self.joints_left > 0 else ["FASTENED"]
        kind = self.draw(st.sampled_from(kinds[:3] if moves else kinds), label="kind")
        entities = [(one, self._frame()), (onto, self._frame())]
        if self.draw(st.booleans(), label="reversed"):
            entities.reverse()
        name = f"{kind.capitalize()} {len(nodes) - 1}"
        if kind == "FASTENED":
            assembly.fasten(name, *entities)
            return
        self.joints_left -= 1
        make = assembly.revolute if kind == "REVOLUTE" else assembly.slider
        moving.append((ORIGIN, make(name, *entities, limits=self._limits(kind))))

    def _gears(self, mates):
        turning = [pair for pair in mates if pair[1].type == "REVOLUTE"]
        for index in range(self.draw(st.integers(0, min(2, len(turning) // 2)), label="gears")):
            first, second = turning[2 * index], turning[2 * index + 1]
            ratio, reverse = float(self.rng.uniform(0.3, 2.0)), bool(self.rng.random() < 0.5)
            self.document.root.gear(f"Gear {index + 1}", first, second, ratio, reverse=reverse)
            value = self.document.values[first[0].path, first[1].id]
            self.document.set_value(*second, (ratio if reverse else -ratio) * value)

    def _loops(self, occurrences):
        for index in range(self.draw(st.integers(1, 2), label="loops")):
            truth = self.document.truth
            one, two = self.draw(st.tuples(*[st.sampled_from(occurrences)] * 2), label="loop")
            if touching(truth, one.path, two.path):
                continue
            poses = truth.poses()
            frame, value = self._frame(), self._value("REVOLUTE")
            there = product(poses[two.path], frame, motion("REVOLUTE", value))
            ends = (one, product(inverse(poses[one.path]), there)), (two, frame)
            self.document.root.revolute(f"Closing {index + 1}", *ends, limits=(-3.0, 3.0), closing=True)

    def _value(self, kind):
        return float(self.rng.uniform(-1.2, 1.2) if kind == "REVOLUTE" else self.rng.uniform(-0.2, 0.2))

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


def touching(truth, one, two):
    """Whether two parts are of one body, or of two that a mate joins: there another one closes no loop
    but takes away motion."""
    weld = {path: number for number, paths in enumerate(truth.tree.welds()) for path in paths}
    pairs = [{weld[edge.first], weld[edge.second]} for edge in truth.joints]
    return weld[one] == weld[two] or {weld[one], weld[two]} in pairs
