"""Which geoms collide, by MuJoCo's bits: two do if `contype` of the one and `conaffinity` of the other have a
bit in common.

A geom that collides with everything has 1 and 1. The others form classes that want the same, each with a bit
of its own; its `conaffinity` has the 1, and the bits of all classes that it collides with: so whatever has a
1 in its `contype`, like the floor and what a user adds, collides with all of them. The highest bits come
first, since those that users choose are mostly low.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import numpy.typing as npt

from stages.export.mjcf.left_out import LeftOut
from stages.robot.adjacency import Pair
from stages.robot.geometry import Exclude, Geometry
from stages.robot.model import Robot

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
    """`bits`: `contype` and `conaffinity` of the geoms that do not collide with everything. `pairs`: the
    links of which no geoms collide; `wide`: those of them of which some should, but classes are lacking."""

    bits: Mapping[Geom, tuple[int, int]]
    pairs: tuple[Pair, ...]
    wide: tuple[Pair, ...]


def filters(robot: Robot, geometry: Geometry) -> Filters:
    """What keeps the excludes of `geometry` from colliding, but for what MuJoCo leaves out by itself."""
    left_out = LeftOut(robot)
    needed = [
        exclude
        for one in geometry.excludes
        if not left_out.contains(one.link_a, one.link_b)
        for exclude in ([one] if one.link_a != WORLD else _by_geoms(one, geometry))
    ]
    never = {(one.link_a, one.link_b) for one in needed if not one.geoms}
    chosen: list[Exclude] = []
    classes: list[list[Geom]] = []
    wants: _Wants = np.zeros((0, 0), np.int8)
    wide = []
    for one in needed:
        if not one.geoms:
            continue
        tried = _classes(_geoms(robot, [*chosen, one]), [*chosen, one], never, left_out)
        if len(tried[0]) > CLASSES:
            wide.append((one.link_a, one.link_b))
            never.add(wide[-1])
        else:
            chosen.append(one)
            classes, wants = tried
    pairs = [(one.link_a, one.link_b) for one in needed if (one.link_a, one.link_b) in never]
    return Filters(_bits(classes, wants), tuple(pairs), tuple(wide))


def _by_geoms(exclude: Exclude, geometry: Geometry) -> list[Exclude]:
    """The same by the geoms of the two links, if they have some: the body of the world has the ground too."""
    one, other = (range(len(geometry.of(link, "collision"))) for link in (exclude.link_a, exclude.link_b))
    geoms = exclude.geoms or tuple(product(one, other))
    return [replace(exclude, geoms=geoms)] if geoms else []


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
    geoms: Sequence[Geom], excludes: Sequence[Exclude], never: set[Pair], left_out: LeftOut
) -> tuple[list[list[Geom]], _Wants]:
    """The geoms in few classes, of which all want the same of those of another, and what the classes want of
    each other. Each geom goes to the first class where that holds."""
    apart = {((one.link_a, a), (one.link_b, b)) for one in excludes for a, b in one.geoms}

    def want(one: Geom, other: Geom) -> int:
        links = one[0], other[0]
        if one[0] == other[0] or not never.isdisjoint((links, links[::-1])) or left_out.contains(*links):
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
