"""What holds occurrences together in a document: edges, what they leave free, and relations."""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tests.fake_onshape import mates
from tests.fake_onshape.elements import Instance
from tests.fake_onshape.frames import inverse, product
from tests.fake_onshape.mates import FREEDOMS, MIRROR, OPEN, bounds, dof_names, dof_of, motion, split

Path = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Place:
    """An occurrence: its path, its words ("Arm <1>/Hand <1>") and its last instance.

    `mirrored`: its pose reflects.
    """

    path: Path
    name: str
    instance: Instance
    mirrored: bool = False


@dataclass(frozen=True, eq=False)
class Dof:
    """One thing that an edge leaves free: a turn or a slide about or along `axis` (3,) of the second
    frame, or a ball, whose axis is zero. `value` is the saved one."""

    name: str
    kind: str
    axis: np.ndarray
    value: object
    limits: tuple

    @property
    def width(self):
        """How many columns it has in a Jacobian."""
        return 3 if self.kind == "ball" else 1


@dataclass(frozen=True, eq=False)
class Edge:
    """Two occurrences held together: first @ first_frame == second @ second_frame @ motion(value).

    Both frames are proper in the world. `mirrored`: a mirror made the mate, so that its slide along z
    runs backwards. `copies`: the (pattern, number) that it is a copy by, the seed's own first, and
    `onto`: the copied instances that it moved to, as paths of ids from its owner.
    """

    name: str
    owner: Path
    feature: str
    type: str
    first: Path
    second: Path
    first_frame: np.ndarray
    second_frame: np.ndarray
    value: object = 0.0
    limits: tuple = OPEN
    closing: bool = False
    mirrored: bool = False
    copies: tuple = ()
    onto: tuple = ()

    @property
    def key(self):
        """(owner occurrence path, feature id), and of a copy also the copied instance."""
        return self.owner, self.feature, *self.onto[:1]

    @property
    def keys(self):
        """All that it is found by: with "" for no copy; a copy between two copied instances by either."""
        return [self.key, *((self.owner, self.feature, path) for path in self.onto or ("",))]

    @property
    def moves(self):
        return bool(FREEDOMS[self.type])

    @cached_property
    def dofs(self):
        """In the mate's own order: slides, then the turn."""
        made = []
        values, limits = split(self.type, self.value), bounds(self.type, self.limits)
        names = dof_names(self.type, self.name)
        for freedom, name, value, pair in zip(FREEDOMS[self.type], names, values, limits, strict=True):
            axis = np.eye(3)[freedom.axis] * (freedom.kind != "ball")
            backwards = self.mirrored and freedom.kind == "slide" and freedom.axis == 2
            made.append(Dof(name, freedom.kind, -axis if backwards else axis, value, pair))
        return tuple(made)

    def first_in_second(self, value):
        """The pose (4, 4) of the first occurrence in the second at `value`."""
        between = motion(self.type, value, self.mirrored)
        return product(self.second_frame, between, inverse(self.first_frame))

    def value_at(self, poses):
        """The value that poses of all occurrences give it."""
        return mates.measured(self.type, self._apart(poses), self.mirrored)

    def error(self, poses):
        """How far it is from met: (3,) rad and (3,) m, without its own freedom."""
        return mates.misfit(self.type, self._apart(poses))

    def _apart(self, poses):
        there = {(): np.eye(4), **poses}
        return inverse(there[self.second] @ self.second_frame) @ there[self.first] @ self.first_frame

    def proper(self, first_mirrored, second_mirrored):
        """The same with proper frames; ValueError where only one of the two is left-handed."""
        sides = ((first_mirrored, self.first_frame), (second_mirrored, self.second_frame))
        handed = [mirrored != (np.linalg.det(frame[:3, :3]) < 0) for mirrored, frame in sides]
        if handed[0] != handed[1]:
            msg = f"{self.name!r} joins a left-handed frame to a right-handed one"
            raise ValueError(msg)
        if not handed[0]:
            return self
        return replace(
            self,
            first_frame=product(self.first_frame, MIRROR),
            second_frame=product(self.second_frame, MIRROR),
            value=mates.in_the_mirror(self.type, self.value),
            mirrored=not self.mirrored,
        )


@dataclass(frozen=True, eq=False)
class Coupling:
    """A relation: `follower` = multiplier · `driver` + offset, both names of dofs."""

    name: str
    driver: str
    follower: str
    multiplier: float
    offset: float = 0.0


def coupling(name, relation, words):
    """The `Coupling` of a relation feature; `words`: the name of its owner's occurrence."""
    ends = [(mate.type, _joint_name(words, owner, mate)) for owner, mate in relation.mates]
    if relation.type == "SCREW":
        kinds, ends = ("turn", "slide"), ends * 2
    elif relation.type == "RACK_AND_PINION":
        kinds = _pinion_first(relation.mates)
    else:
        kinds = ("turn" if relation.type == "GEAR" else "slide",) * 2
    driver, follower = (dof_of(*end, kind) for end, kind in zip(ends, kinds, strict=True))
    k = relation.amount
    if relation.by_length:
        k = k / math.tau if kinds[0] == "turn" else math.tau / k
    return Coupling(name, driver, follower, k if relation.reverse else -k, relation.offset)


def _pinion_first(pair_of_mates):
    """(turn, slide) or (slide, turn): what the two mates of a rack and pinion contribute."""
    first, second = ({freedom.kind for freedom in FREEDOMS[mate.type]} for _, mate in pair_of_mates)
    orders = (("turn", "slide"), ("slide", "turn"))
    kinds = [pair for pair in orders if pair[0] in first and pair[1] in second]
    if len(kinds) != 1:
        msg = f"a rack and pinion needs a turn and a slide: {[mate.name for _, mate in pair_of_mates]}"
        raise ValueError(msg)
    return kinds[0]


def _joint_name(words, owner, mate):
    return "/".join([*([words] if words else []), *(i.name for i in owner.instances), mate.name])


def weld_leaders(places, edges):
    """A function that gives all occurrences that edges join, directly or not, the same leader."""
    leader = {path: path for path in [(), *places]}
    for edge in edges:
        leader[find_leader(leader, edge.first)] = find_leader(leader, edge.second)
    return lambda path: find_leader(leader, path)


def find_leader(leader, path):
    while leader[path] != path:
        path = leader[path]
    return path
