"""Which geoms collide: bodies that do not are excluded, and those of their geoms that do are pairs.

Names say which, so two copies of the robot in one scene collide with each other. Geoms of the link `world`
lie in MuJoCo's worldbody, where the ground is too, so this body cannot be excluded. There bits decide: two
geoms collide if `contype` of the one and `conaffinity` of the other have a bit in common. A geom that
collides with everything has 1 and 1. The others form classes that want the same, each with a bit of its own;
its `conaffinity` has the 1, and the bits of all classes that it collides with: so whatever has a 1 in its
`contype`, like the floor and what a user adds, collides with all of them. The highest bits come first, since
those that users choose are mostly low.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.contact.left_out import LeftOut
from linkwright.stages.robot.model.geometry import Exclude, Geometry
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.adjacency import Pair

Geom = tuple[str, int]
"""A link, and a position among its collision shapes."""

WORLD = "world"
"""The link that is the assembly's origin: MuJoCo's worldbody."""

CLASSES = 30
"""How many classes there can be: bits 1 to 30 of MuJoCo's integers."""

_Wants = npt.NDArray[np.int8]
"""(n, n): 1 where two are to collide, -1 where not, 0 where it does not matter."""


@dataclass(frozen=True, slots=True)
class Filters:
    """`pairs`: the links that are excluded; `kept`: the geoms of these that collide all the same. `bits`:
    `contype` and `conaffinity` of geoms that do not collide with some of the link `world`; `wide`: links of
    which some geoms should collide with those of `world`, but classes are lacking."""

    pairs: tuple[Pair, ...]
    kept: tuple[tuple[Geom, Geom], ...]
    bits: Mapping[Geom, tuple[int, int]]
    wide: tuple[Pair, ...]


def filters(robot: Robot, geometry: Geometry) -> Filters:
    """What keeps the excludes of `geometry` from colliding, but for what MuJoCo leaves out by itself, and
    what an MJCF source keeps apart."""
    left_out = LeftOut(robot)
    needed = [
        one
        for one in geometry.excludes
        if not (geometry.by_source and one.reason == "Source")
        and not left_out.contains(one.link_a, one.link_b)
    ]
    excluded = [one for one in needed if one.link_a != WORLD]
    chosen: list[Exclude] = []
    classes: list[list[Geom]] = []
    wants: _Wants = np.zeros((0, 0), np.int8)
    wide = []
    for one in needed:
        geoms = one.geoms or tuple(_geom_pairs(one, geometry))
        if one.link_a != WORLD or not geoms:
            continue
        tried = [*chosen, replace(one, geoms=geoms)]
        found = _classes(_geoms(robot, tried), tried, left_out)
        if len(found[0]) > CLASSES:
            wide.append((one.link_a, one.link_b))
        else:
            chosen, (classes, wants) = tried, found
    pairs = [*((one.link_a, one.link_b) for one in excluded), *wide]
    kept = [pair for one in excluded for pair in _kept(one, geometry)]
    return Filters(tuple(pairs), tuple(kept), _bits(classes, wants), tuple(wide))


def _geom_pairs(exclude: Exclude, geometry: Geometry) -> Iterator[tuple[int, int]]:
    """Each geom of the one link with each of the other."""
    one, other = (range(len(geometry.of(link, "collision"))) for link in (exclude.link_a, exclude.link_b))
    return product(one, other)


def _kept(exclude: Exclude, geometry: Geometry) -> Iterator[tuple[Geom, Geom]]:
    """The geoms of two links that collide, where others of them do not."""
    if exclude.geoms:
        apart = set(exclude.geoms)
        for a, b in _geom_pairs(exclude, geometry):
            if (a, b) not in apart:
                yield (exclude.link_a, a), (exclude.link_b, b)


def _bits(classes: Sequence[Sequence[Geom]], wants: _Wants) -> dict[Geom, tuple[int, int]]:
    own = [1 << (CLASSES - number) for number in range(len(classes))]
    found: dict[Geom, tuple[int, int]] = {}
    for number, geoms in enumerate(classes):
        others = sum(bit for bit, want in zip(own, wants[number], strict=True) if want >= 0)
        found |= dict.fromkeys(geoms, (own[number], 1 + others))
    return found


def _geoms(robot: Robot, excludes: Sequence[Exclude]) -> list[Geom]:
    """The geoms of the excludes, in the order of the links."""
    place = {link.name: index for index, link in enumerate(robot.links)}
    found = {(one.link_a, a) for one in excludes for a, _ in one.geoms}
    found |= {(one.link_b, b) for one in excludes for _, b in one.geoms}
    return sorted(found, key=lambda geom: (place[geom[0]], geom[1]))


def _classes(
    geoms: Sequence[Geom], excludes: Sequence[Exclude], left_out: LeftOut
) -> tuple[list[list[Geom]], _Wants]:
    """The geoms in few classes, of which all want the same of those of another, and what the classes want of
    each other. Each geom goes to the first class where that holds."""
    apart = {((one.link_a, a), (one.link_b, b)) for one in excludes for a, b in one.geoms}

    def want(one: Geom, other: Geom) -> int:
        if one[0] == other[0] or left_out.contains(one[0], other[0]):
            return 0
        return 1 if apart.isdisjoint(((one, other), (other, one))) else -1

    wants = np.array([[want(one, other) for other in geoms] for one in geoms], np.int8)
    classes = [[geom] for geom in geoms]
    first = 0
    while first < len(classes):
        second = first + 1
        while second < len(classes):
            if _agree(wants, first, second):
                classes[first] += classes.pop(second)
                wants = _joined(wants, first, second)
            else:
                second += 1
        first += 1
    return classes, wants


def _agree(wants: _Wants, one: int, other: int) -> bool:
    """Whether a class and a single geom, which wants nothing of itself, want nothing different."""
    return bool((wants[one] * wants[other] >= 0).all())


def _joined(wants: _Wants, one: int, other: int) -> _Wants:
    """What classes want once two that agree are one."""
    joined = wants.copy()
    joined[one] = np.where(joined[one] == 0, joined[other], joined[one])
    joined[:, one] = np.where(joined[:, one] == 0, joined[:, other], joined[:, one])
    return np.delete(np.delete(joined, other, axis=0), other, axis=1)
