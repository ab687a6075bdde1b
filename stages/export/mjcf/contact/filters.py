"""Decides which geoms collide, by excluded bodies, pairs of geoms, and bits of geoms.

Bodies that do not collide are excluded by name, and their geoms that collide nevertheless are pairs. Because
of the names, two copies of the robot in one scene collide with each other.

Geoms of the link `world` are in MuJoCo's worldbody, as the ground is, so this body cannot be excluded. Bits
decide for them: two geoms collide if `contype` of the one and `conaffinity` of the other have a bit in
common. A geom that collides with everything has 1 and 1. The other geoms form classes that collide with the
same geoms, and each class has its own bit. The `conaffinity` of a class has the bit 1, and the bits of all
classes that it collides with. Any geom with the bit 1 in its `contype`, such as the floor or a user's geom,
thus collides with all of them. The highest bits are used first, because users mostly choose low bits.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.contact.left_out import FilteredPairs
from linkwright.stages.robot.model.geometry import Exclude, Geometry
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.adjacency import Pair

Geom = tuple[str, int]
"""(link, index among its collision shapes)."""

WORLD = "world"
"""The link at the assembly's origin: MuJoCo's worldbody."""

MAX_CLASSES = 30
"""Largest number of classes: bits 1 to 30 of MuJoCo's integers."""

_Wants = npt.NDArray[np.int8]
"""(n, n): 1 if two classes should collide, -1 if they should not, 0 if it does not matter."""


@dataclass(frozen=True, slots=True)
class Filters:
    """The contact filters of an MJCF."""

    pairs: tuple[Pair, ...]
    """The pairs of links that are excluded."""

    kept: tuple[tuple[Geom, Geom], ...]
    """The pairs of geoms of excluded links that collide nevertheless."""

    bits: Mapping[Geom, tuple[int, int]]
    """Geom → `contype` and `conaffinity`, for geoms that do not collide with some geoms of the link
    `world`."""

    wide: tuple[Pair, ...]
    """The pairs (`world`, link) that are excluded as a whole, because there are too few classes to exclude
    only some of their geoms."""


def filters(robot: Robot, geometry: Geometry) -> Filters:
    """Returns the filters for the excludes of `geometry`, without pairs that MuJoCo leaves out by itself or
    that an MJCF source already excludes."""
    left_out = FilteredPairs(robot)
    needed = [
        exclude
        for exclude in geometry.excludes
        if not (geometry.by_source and exclude.reason == "Source")
        and not left_out.contains(exclude.link_a, exclude.link_b)
    ]
    excluded = [exclude for exclude in needed if exclude.link_a != WORLD]
    chosen: list[Exclude] = []
    classes: list[list[Geom]] = []
    wants: _Wants = np.zeros((0, 0), np.int8)
    wide = []
    for exclude in needed:
        geoms = exclude.geoms or tuple(_geom_pairs(exclude, geometry))
        if exclude.link_a != WORLD or not geoms:
            continue
        candidates = [*chosen, replace(exclude, geoms=geoms)]
        classified = _classes(_geoms(robot, candidates), candidates, left_out)
        if len(classified[0]) > MAX_CLASSES:
            wide.append((exclude.link_a, exclude.link_b))
        else:
            chosen, (classes, wants) = candidates, classified
    pairs = [*((exclude.link_a, exclude.link_b) for exclude in excluded), *wide]
    kept = [pair for exclude in excluded for pair in _kept(exclude, geometry)]
    return Filters(tuple(pairs), tuple(kept), _bits(classes, wants), tuple(wide))


def _geom_pairs(exclude: Exclude, geometry: Geometry) -> Iterator[tuple[int, int]]:
    """Returns each geom of the first link with each geom of the second."""
    firsts, seconds = (
        range(len(geometry.shapes_of(link, "collision"))) for link in (exclude.link_a, exclude.link_b)
    )
    return product(firsts, seconds)


def _kept(exclude: Exclude, geometry: Geometry) -> Iterator[tuple[Geom, Geom]]:
    """Yields the geoms of two links that collide, although other geoms of these links do not."""
    if exclude.geoms:
        excluded = set(exclude.geoms)
        for a, b in _geom_pairs(exclude, geometry):
            if (a, b) not in excluded:
                yield (exclude.link_a, a), (exclude.link_b, b)


def _bits(classes: Sequence[Sequence[Geom]], wants: _Wants) -> dict[Geom, tuple[int, int]]:
    class_bits = [1 << (MAX_CLASSES - number) for number in range(len(classes))]
    masks: dict[Geom, tuple[int, int]] = {}
    for number, geoms in enumerate(classes):
        colliding = sum(bit for bit, want in zip(class_bits, wants[number], strict=True) if want >= 0)
        masks |= dict.fromkeys(geoms, (class_bits[number], 1 + colliding))
    return masks


def _geoms(robot: Robot, excludes: Sequence[Exclude]) -> list[Geom]:
    """Returns the geoms of the excludes, in the order of the links."""
    index_of_link = {link.name: index for index, link in enumerate(robot.links)}
    geoms = {(exclude.link_a, a) for exclude in excludes for a, _ in exclude.geoms}
    geoms |= {(exclude.link_b, b) for exclude in excludes for _, b in exclude.geoms}
    return sorted(geoms, key=lambda geom: (index_of_link[geom[0]], geom[1]))


def _classes(
    geoms: Sequence[Geom], excludes: Sequence[Exclude], left_out: FilteredPairs
) -> tuple[list[list[Geom]], _Wants]:
    """Returns few classes of geoms with compatible wants, and the wants of the classes. Each geom joins the
    first class that fits."""
    excluded_pairs = {
        ((exclude.link_a, a), (exclude.link_b, b)) for exclude in excludes for a, b in exclude.geoms
    }

    def want(exclude: Geom, other: Geom) -> int:
        if exclude[0] == other[0] or left_out.contains(exclude[0], other[0]):
            return 0
        return 1 if excluded_pairs.isdisjoint(((exclude, other), (other, exclude))) else -1

    wants = np.array([[want(exclude, other) for other in geoms] for exclude in geoms], np.int8)
    classes = [[geom] for geom in geoms]
    first = 0
    while first < len(classes):
        second = first + 1
        while second < len(classes):
            if _compatible(wants, first, second):
                classes[first] += classes.pop(second)
                wants = _merged_wants(wants, first, second)
            else:
                second += 1
        first += 1
    return classes, wants


def _compatible(wants: _Wants, first: int, second: int) -> bool:
    """Returns whether a class and a class of a single geom have no conflicting wants."""
    return bool((wants[first] * wants[second] >= 0).all())


def _merged_wants(wants: _Wants, first: int, second: int) -> _Wants:
    """Returns the wants of the classes, after two classes that agree are merged."""
    merged = wants.copy()
    merged[first] = np.where(merged[first] == 0, merged[second], merged[first])
    merged[:, first] = np.where(merged[:, first] == 0, merged[:, second], merged[:, first])
    return np.delete(np.delete(merged, second, axis=0), second, axis=1)
