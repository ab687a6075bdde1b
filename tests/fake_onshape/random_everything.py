"""Random documents, plain ones and those with all that an assembly can hold.

Mates of every type, some reversed, some drawn twice, some to an assembly's origin; mate groups; patterns
and mirrors of parts and of sub-assemblies, some of parts that only the assembly around them holds;
relations in chains; loops that close by a hinge or a ball.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from hypothesis import strategies as st

from tests.fake_onshape.document import ORIGIN
from tests.fake_onshape.elements import Mate
from tests.fake_onshape.frames import frame, inverse, product
from tests.fake_onshape.mates import FREEDOMS, OPEN, joined, motion, split
from tests.fake_onshape.random_document import Author, touching

PLAIN = ("REVOLUTE", "REVOLUTE", "SLIDER")
MOVING = ("REVOLUTE", "SLIDER", "CYLINDRICAL", "BALL", "PLANAR", "PIN_SLOT", "PARALLEL")
DOUBLED = ("REVOLUTE", "SLIDER", "CYLINDRICAL")
"""Types of mates that can be drawn a second time."""


@dataclass(eq=False)
class _Node:
    """One instance: occurrences of its parts, its moving (owner, mate)s; `twins`: (owner, owner of the
    copy, mate) inside copies, which have the seed's values; `host`: the node that it hangs on."""

    at: object
    parts: list
    mates: list = field(default_factory=list)
    twins: list = field(default_factory=list)
    host: "_Node | None" = None

    def within(self, outer):
        """(parts, mates, twins) as seen from the assembly that `outer` is in."""
        return (
            [outer / part for part in self.parts],
            [(outer / owner, mate) for owner, mate in self.mates],
            [(outer / seed, outer / copy, mate) for seed, copy, mate in self.twins],
        )


@dataclass(eq=False)
class _Made:
    """A finished assembly: itself, all that is in it as one node, the number of levels below it, that of
    its parts, and what in it the assembly around must hold."""

    assembly: object
    whole: _Node
    levels: int
    size: int
    loose: tuple = ()


class Everything(Author):
    """Draws one document; see `random_document.documents`."""

    def __init__(self, draw, max_bodies, depth, everything):
        super().__init__(draw, max_bodies, depth)
        self.everything, self.must_move, self.moved = everything, False, False

    def write(self, gears, loops, fixed):
        ways = {True: ["fixed"], False: ["free", "origin"], None: ["fixed", "free", "origin", "held"]}[fixed]
        if not self.everything:
            ways = [way for way in ways if way in ("fixed", "free")]
        made = self._build("Robot", self.depth, self.draw(st.sampled_from(ways), label="base"))
        self.document.root, whole = made.assembly, made.whole
        for owner, mate in whole.mates:
            self.document.set_value(owner, mate, self._value(mate.type))
        if gears:
            self._relations(whole.mates)
        for seed, copy, mate in whole.twins:
            self.document.set_value(copy, mate, self.document.values[seed.path, mate.id])
        if loops:
            self._loops(whole.parts)
        self.document.truth.check()
        return self.document

    def _build(self, name, depth, base=""):
        sources = [self.draw(st.sampled_from(self.parts), label="part")]
        self.parts_left -= 1
        for _ in range(self.draw(st.integers(1, 3), label="instances")):
            if self.parts_left > 0:
                sources.append(self._source(depth))
        assembly = self.document.assembly(f"{name} {len(self.made) + 1}")
        nodes = []
        for index, source in enumerate(sources):
            held = base == "fixed" and index == 0
            pose = None if index else self._frame()
            nodes.append(self._add(assembly, source, fixed=held, pose=pose))
            if index:
                self.must_move = depth == self.depth and index == len(sources) - 1
                self._hang(assembly, nodes, onto_origin=not base or base in ("fixed", "origin"))
            for inside in getattr(source, "loose", ()):
                node = nodes[-1]
                onto = self.draw(st.sampled_from((node.host or node).parts), label="holds")
                self._join(assembly, f"Holds {len(nodes)}", node, node.at / inside, onto)
        if base == "origin":
            self._join(assembly, "Grounded", nodes[0], nodes[0].at, ORIGIN)
        if base == "held":
            everything = [part for node in nodes for part in node.parts]
            assembly.fix(self.draw(st.sampled_from(everything), label="held"))
        if not base:
            self._carry(assembly, nodes)
        copies = self._copies(assembly, nodes) if self.everything else []
        loose = [] if base or not self.everything else self._loose(assembly)
        whole = _Node(
            ORIGIN,
            [part for node in nodes for part in node.parts],
            [mate for node in (*nodes, *loose) for mate in node.mates],
            [twin for node in (*nodes, *copies) for twin in node.twins],
        )
        levels = 1 + max([source.levels for source in sources if isinstance(source, _Made)], default=0)
        size = sum(len(node.parts) for node in (*nodes, *copies)) + 2 * sum(len(node.parts) for node in loose)
        self.made.append(_Made(assembly, whole, levels, size, tuple(node.at for node in loose)))
        return self.made[-1]

    def _carry(self, assembly, nodes):
        """Say what carries a sub-assembly's frame; where mates need to know, by fastening it there."""
        at, pose = self._frame(), self._frame()
        mates = (feature for feature in assembly.features if isinstance(feature, Mate))
        ends = [entity for mate in mates for entity in mate.entities]
        if any(not occurrence.path for occurrence, _ in ends):
            assembly.ground(nodes[0].at, pose)
            carried = (nodes[0].at, at), (ORIGIN, product(pose, at))
            assembly.fasten("Carried", *carried, redundant=True)
        else:
            parts = [part for node in nodes for part in node.parts]
            assembly.ground(parts[self.rng.integers(len(parts))], pose)

    def _source(self, depth):
        """A part, one of the assemblies made so far, or a new one."""
        if depth > 1 and self.draw(st.booleans(), label="nested"):
            fits = [
                made
                for made in self.made
                if made.size <= self.parts_left
                and made.levels < depth
                and (self.everything or len(made.whole.mates) <= self.joints_left)
            ]
            if fits and self.draw(st.booleans(), label="again"):
                made = self.draw(st.sampled_from(fits), label="which")
                self.parts_left -= made.size
                self.joints_left -= len(made.whole.mates)
                return made
            return self._build("Sub", depth - 1)
        self.parts_left -= 1
        return self.draw(st.sampled_from(self.parts), label="part")

    def _add(self, assembly, source, **more):
        nested = isinstance(source, _Made)
        hidden = bool(self.rng.random() < 0.1)
        at = assembly.add(source.assembly if nested else source, hidden=hidden, **more)
        return _Node(at, *source.whole.within(at)) if nested else _Node(at, [at])

    def _loose(self, assembly):
        """A patterned or mirrored part that only the assembly around holds, at times with one on it."""
        if self.parts_left < 4 or not self.draw(st.booleans(), label="loose"):
            return []
        node = _Node(assembly.add(self.draw(st.sampled_from(self.parts), label="part")), [])
        seeds = [node.at]
        if self.draw(st.booleans(), label="carries"):
            seeds.append(assembly.add(self.draw(st.sampled_from(self.parts), label="part")))
            self._join(assembly, "Carries", node, seeds[1], node.at)
        node.parts = seeds
        self.parts_left -= 2 * len(seeds)
        if self.draw(st.booleans(), label="mirror"):
            self._mirror(assembly, "Loose mirror", seeds)
        else:
            assembly.pattern("Loose pattern", seeds, [self._frame()], "CIRCULAR")
        return [node]

    def _mirror(self, assembly, name, seeds):
        """A mirror, at times with new parts as the images of parts."""
        new = self.draw(st.booleans(), label="new parts")
        return assembly.mirror(name, seeds, self._frame(), self._frame() if new else None)

    def _hang(self, assembly, nodes, onto_origin):
        """Hang the last node on one of those before it, or on the assembly's origin."""
        node = nodes[-1]
        name, part = f"Mate {len(nodes) - 1}", self.draw(st.sampled_from(node.parts), label="one")
        if onto_origin and self.everything and self.rng.random() < 0.15:
            self._join(assembly, name, node, part, ORIGIN)
            return
        node.host = self.draw(st.sampled_from(nodes[:-1]), label="host")
        onto = self.draw(st.sampled_from(node.host.parts), label="onto")
        self._join(assembly, name, node, part, onto)

    def _join(self, assembly, name, node, part, onto):
        moving = (MOVING if self.everything else PLAIN) if self.joints_left > 0 else ()
        kinds = [*moving, "FASTENED", *(["GROUP"] if onto.path and self.everything else [])]
        if moving and not self.everything and self.must_move and not self.moved:
            kinds = moving
        kind = self.draw(st.sampled_from(kinds), label="kind")
        if kind == "GROUP":
            assembly.group(name, [(onto, np.eye(4)), (part, self._frame())])
            return
        ends = [(part, self._frame()), (onto, self._frame())]
        if self.draw(st.booleans(), label="reversed"):
            ends.reverse()
        if kind == "FASTENED":
            assembly.fasten(name, *ends)
            return
        mate = getattr(assembly, kind.lower())(name, *ends, limits=self._bounds(kind))
        self.joints_left -= 1
        self.moved = True
        node.mates.append((ORIGIN, mate))
        if self.everything and kind in DOUBLED and self.rng.random() < 0.2:
            # Anywhere along the common axis; turned about both ways, as a second author would draw it.
            along = frame((0, 0, float(self.rng.uniform(-0.2, 0.2))))
            again = [(occurrence, product(at, along)) for occurrence, at in ends]
            if self.rng.random() < 0.5:
                again.reverse()
            getattr(assembly, kind.lower())(f"{name} again", *again, redundant=True)

    def _copies(self, assembly, nodes):
        """Nodes that hold the twins inside the copies of one or two patterns or mirrors."""
        made, hosts, copied_nodes = [], set(), set()
        for index in range(self.draw(st.integers(0, 2), label="patterns")):
            seed = self.draw(st.sampled_from(nodes[1:] or nodes), label="seed")
            seeds = [node for node in nodes if _hangs_on(node, seed)]
            size = sum(len(node.parts) for node in seeds)
            # What carries copies is not copied itself: the one would have to be done before the other.
            ids = {id(seed) for seed in seeds}
            nested = hosts & ids or id(seed.host) in copied_nodes
            if seed is nodes[0] or size > self.parts_left or nested:
                continue
            hosts.add(id(seed.host))
            copied_nodes |= ids
            self.parts_left -= size
            if self.draw(st.booleans(), label="mirror"):
                images = self._mirror(assembly, f"Mirror {index + 1}", [seed.at for seed in seeds])
                copied = [(image,) for image in images]
            else:
                circular = self.draw(st.booleans(), label="circular")
                moved = self._frame()
                if not circular:
                    moved[:3, :3] = np.eye(3)
                count = 2 if size * 2 <= self.parts_left + size else 1
                moves = [moved, product(moved, moved)][:count]
                self.parts_left -= size * (count - 1)
                kind = "CIRCULAR" if circular else "LINEAR"
                copied = assembly.pattern(f"Pattern {index + 1}", [seed.at for seed in seeds], moves, kind)
            made += [self._copy(seed, at) for seed, ats in zip(seeds, copied, strict=True) for at in ats]
        return made

    @staticmethod
    def _copy(seed, at):
        """The copy of a node: what moves inside it has the values that it has in the seed."""
        mates = [*seed.mates, *((copy, mate) for _, copy, mate in seed.twins)]
        inside = [(owner, mate) for owner, mate in mates if owner.instances]
        parts = [at / _tail(part) for part in seed.parts]
        return _Node(at, parts, twins=[(owner, at / _tail(owner), mate) for owner, mate in inside])

    def _relations(self, mates):
        """Up to four relations: what follows has not been related before; what drives it may have."""
        related = set()  # (place of a mate among `mates`, index of its freedom)
        for index in range(self.draw(st.integers(0, 4), label="relations")):
            kinds = ("GEAR", "LINEAR", "RACK_AND_PINION", "SCREW")[: None if self.everything else 1]
            kind = self.draw(st.sampled_from(kinds), label="relation")
            pairs = [
                (driver, follower)
                for driver, follower in _pairs(kind, mates)
                if follower not in related and (self.everything or driver not in related)
            ]
            if not pairs:
                continue
            driver, follower = self.draw(st.sampled_from(pairs), label="pair")
            related |= {driver, follower}
            self._relate(f"Relation {index + 1}", kind, mates, driver, follower)

    def _relate(self, name, kind, mates, driver, follower):
        root, reverse = self.document.root, bool(self.rng.random() < 0.5)
        first, second = mates[driver[0]], mates[follower[0]]
        turns = FREEDOMS[first[1].type][driver[1]].kind == "turn"
        at = self._get(first, driver[1])
        if kind in ("GEAR", "LINEAR"):
            most = 2.4 if turns else 0.2
            amount = k = min(float(self.rng.uniform(0.3, 2.0)), most / max(abs(at), 1e-3))
        else:
            amount = float(self.rng.uniform(0.02, 0.2) if turns else self.rng.uniform(0.6, 2.0))
            k = amount / math.tau if turns else math.tau / amount
        drawn = (k if reverse else -k) * at
        # As it is drawn, the other way round, or anywhere: the sign is the same in all three.
        saved = drawn
        if self.everything:
            saved = [drawn, -drawn, self._get(second, follower[1])][self.rng.choice(3, p=(0.6, 0.2, 0.2))]
        make = {"GEAR": root.gear, "LINEAR": root.linear, "RACK_AND_PINION": root.rack, "SCREW": root.screw}
        ends = (first,) if kind == "SCREW" else (first, second)
        make[kind](name, *ends, amount, reverse=reverse, offset=saved - drawn)
        self._set(second, follower[1], saved)

    def _get(self, pair, index):
        owner, mate = pair
        return split(mate.type, self.document.values[owner.path, mate.id])[index]

    def _set(self, pair, index, number):
        owner, mate = pair
        values = list(split(mate.type, self.document.values[owner.path, mate.id]))
        values[index] = number
        self.document.set_value(owner, mate, joined(mate.type, tuple(values)))

    def _loops(self, occurrences):
        for index in range(self.draw(st.integers(1, 2), label="loops")):
            truth = self.document.truth
            first, second = self.draw(st.tuples(*[st.sampled_from(occurrences)] * 2), label="loop")
            if touching(truth, first.path, second.path):
                continue
            kinds = ["REVOLUTE", "BALL"] if self.everything else ["REVOLUTE"]
            kind = self.draw(st.sampled_from(kinds), label="closing")
            poses, at = truth.poses(), self._frame()
            there = product(poses[second.path], at, motion(kind, self._value(kind)))
            ends = (first, product(inverse(poses[first.path]), there)), (second, at)
            limits = {} if self.everything else {"limits": (-3.0, 3.0)}
            close = getattr(self.document.root, kind.lower())
            close(f"Closing {index + 1}", *ends, closing=True, **limits)

    def _value(self, kind):
        if kind == "BALL":
            axis, angle = self.rng.normal(size=3), float(self.rng.uniform(-1.2, 1.2))
            axis = math.sin(angle / 2) * axis / np.linalg.norm(axis)
            return (math.cos(angle / 2), *(float(part) for part in axis))
        reach = {"turn": 1.2, "slide": 0.2}
        numbers = (float(self.rng.uniform(-1, 1)) * reach[freedom.kind] for freedom in FREEDOMS[kind])
        return joined(kind, tuple(numbers))

    def _bounds(self, kind):
        if kind == "BALL":
            return float(self.rng.uniform(1.3, 2.0)) if self.rng.random() < 0.5 else None
        pairs = tuple(
            self._limits("REVOLUTE" if freedom.kind == "turn" else "SLIDER") for freedom in FREEDOMS[kind]
        )
        return joined(kind, pairs) if any(pair != OPEN for pair in pairs) else OPEN


def _tail(occurrence):
    """An occurrence as seen from inside the first instance of its path."""
    return type(occurrence)(occurrence.instances[1:])


def _hangs_on(node, seed):
    while node is not None and node is not seed:
        node = node.host
    return node is seed


def _pairs(kind, mates):
    """((mate, freedom) of the driver, of the follower) that a relation of this kind can have, by places."""
    places = {"turn": [], "slide": []}
    for at, (_, mate) in enumerate(mates):
        for wanted, spots in places.items():
            own = [i for i, freedom in enumerate(FREEDOMS[mate.type]) if freedom.kind == wanted]
            spots += [(at, own[0])] if len(own) == 1 else []
    if kind == "SCREW":
        cylinders = [at for at, (_, mate) in enumerate(mates) if mate.type == "CYLINDRICAL"]
        return [((at, 1), (at, 0)) for at in cylinders]
    if kind in ("GEAR", "LINEAR"):
        same = places["turn" if kind == "GEAR" else "slide"]
        return [(first, second) for first in same for second in same if first[0] != second[0]]
    # Of mates that leave both free, which one is the rack would not be said.
    turns = [place for place in places["turn"] if mates[place[0]][1].type == "REVOLUTE"]
    slides = [place for place in places["slide"] if mates[place[0]][1].type == "SLIDER"]
    return [pair for turn in turns for slide in slides for pair in ((turn, slide), (slide, turn))]
