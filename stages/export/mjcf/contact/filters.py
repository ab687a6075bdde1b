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
"""Wants (n, n) of classes: 1 if two classes should collide, -1 if they should not, 0 if it does not
matter."""


@dataclass(frozen=True, slots=True)
class Filters:
    """The contact filters of an MJCF."""

    excluded_pairs: tuple[Pair, ...]
    """The pairs of links that are excluded."""

    colliding_geoms: tuple[tuple[Geom, Geom], ...]
    """The pairs of geoms of excluded links that collide nevertheless."""

    bits: Mapping[Geom, tuple[int, int]]
    """Geom → `contype` and `conaffinity`, for geoms that do not collide with some geoms of the link
    `world`."""

    widened_pairs: tuple[Pair, ...]
    """The pairs (`world`, link) that are excluded as a whole, because there are too few bits to exclude only
    some of their geoms."""


def filters_of(robot: Robot, geometry: Geometry) -> Filters:
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
    excludes_by_bits: list[Exclude] = []
    classes: list[list[Geom]] = []
    wants: _Wants = np.zeros((0, 0), np.int8)
    widened_pairs = []
    for exclude in needed:
        geoms = exclude.geoms or tuple(_geom_pairs(exclude, geometry))
        if exclude.link_a != WORLD or not geoms:
            continue
        candidates = [*excludes_by_bits, replace(exclude, geoms=geoms)]
        classified = _classes(_geoms(robot, candidates), candidates, left_out)
        if len(classified[0]) > MAX_CLASSES:
            widened_pairs.append((exclude.link_a, exclude.link_b))
        else:
            excludes_by_bits, (classes, wants) = candidates, classified
    excluded_pairs = [*((exclude.link_a, exclude.link_b) for exclude in excluded), *widened_pairs]
    colliding_geoms = [pair for exclude in excluded for pair in _colliding_geoms(exclude, geometry)]
    return Filters(tuple(excluded_pairs), tuple(colliding_geoms), _bits(classes, wants), tuple(widened_pairs))


def _geom_pairs(exclude: Exclude, geometry: Geometry) -> Iterator[tuple[int, int]]:
    """Returns (index of a geom of the first link, index of a geom of the second) of all their geoms."""
    indices_of_first, indices_of_second = (
        range(len(geometry.shapes_of(link, "collision"))) for link in (exclude.link_a, exclude.link_b)
    )
    return product(indices_of_first, indices_of_second)


def _colliding_geoms(exclude: Exclude, geometry: Geometry) -> Iterator[tuple[Geom, Geom]]:
    """Yields the geoms of two links that collide, although other geoms of these links do not."""
    if exclude.geoms:
        excluded = set(exclude.geoms)
        for a, b in _geom_pairs(exclude, geometry):
            if (a, b) not in excluded:
                yield (exclude.link_a, a), (exclude.link_b, b)


def _bits(classes: Sequence[Sequence[Geom]], wants: _Wants) -> dict[Geom, tuple[int, int]]:
    """Returns `contype` and `conaffinity` of the geoms of all classes. `wants`: those of the classes."""
    class_bits = [1 << (MAX_CLASSES - index) for index in range(len(classes))]
    bits: dict[Geom, tuple[int, int]] = {}
    for index, geoms in enumerate(classes):
        colliding = sum(bit for bit, want in zip(class_bits, wants[index], strict=True) if want >= 0)
        # The bit 1 is that of all geoms without a class.
        bits |= dict.fromkeys(geoms, (class_bits[index], 1 + colliding))
    return bits


def _geoms(robot: Robot, excludes: Sequence[Exclude]) -> list[Geom]:
    """Returns the geoms that the excludes name, in the order of the links."""
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

    def want(first: Geom, second: Geom) -> int:
        """Returns whether two geoms should collide, as in `_Wants`."""
        if first[0] == second[0] or left_out.contains(first[0], second[0]):
            return 0
        return 1 if excluded_pairs.isdisjoint(((first, second), (second, first))) else -1

    wants = np.array([[want(first, second) for second in geoms] for first in geoms], np.int8)
    classes = [[geom] for geom in geoms]
    index = 0
    while index < len(classes):
        candidate = index + 1
        while candidate < len(classes):
            if _are_compatible(wants, index, candidate):
                classes[index] += classes.pop(candidate)
                wants = _merged_wants(wants, index, candidate)
            else:
                candidate += 1
        index += 1
    return classes, wants


def _are_compatible(wants: _Wants, first: int, second: int) -> bool:
    """Tells whether two classes have no conflicting wants."""
    return bool((wants[first] * wants[second] >= 0).all())


def _merged_wants(wants: _Wants, first: int, second: int) -> _Wants:
    """Returns the wants of the classes after the class `second` is merged into the compatible class
    `first`."""
    merged = wants.copy()
    merged[first] = np.where(merged[first] == 0, merged[second], merged[first])
    merged[:, first] = np.where(merged[:, first] == 0, merged[:, second], merged[:, first])
    return np.delete(np.delete(merged, second, axis=0), second, axis=1)
