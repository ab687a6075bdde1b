"""Decides which geoms collide, by excluded bodies, pairs of geoms, and bits of geoms.

Bodies that do not collide are excluded by name, and their geoms that collide nevertheless are pairs. Because
of the names, two copies of the robot in one scene collide with each other.

Geoms of the link `world` are in MuJoCo's worldbody, as the ground is, so excluding this body would exclude
the ground too. Bits decide for them instead, unless there are too few bits (`widened_pairs`): two geoms
collide if `contype` of the one and `conaffinity` of the other have a bit in common. A geom that collides with
everything has 1 and 1. The other geoms form classes that collide with the same geoms, and each class has its
own bit. The `conaffinity` of a class has the lowest bit (value 1), and the bits of all classes that it
collides with. Any geom with the lowest bit in its `contype`, such as the floor or a user's geom, thus
collides with all of them. The highest bits are used first, because users mostly choose low bits.
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
"""Largest number of classes, each with its own bit. In MuJoCo's integers of 32 bits, the lowest bit is that
of all other geoms, and the highest is the sign."""

_ShouldCollide = npt.NDArray[np.int8]
"""Whether classes should collide (n, n): 1 if they should, -1 if they must not, 0 if it does not matter."""


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
    """The pairs (`world`, link) that are excluded as a whole, the ground included, because there are too few
    bits for their geoms."""


def filters_of(robot: Robot, geometry: Geometry) -> Filters:
    """Returns the filters for the excludes of `geometry`, without pairs that MuJoCo leaves out by itself or
    that an MJCF source already excludes."""
    filtered_by_mujoco = FilteredPairs(robot)
    needed = [
        exclude
        for exclude in geometry.excludes
        if not (geometry.by_source and exclude.reason == "Source")
        and not filtered_by_mujoco.contains(exclude.link_a, exclude.link_b)
    ]
    # Only the first link can be `world`, since links are in the robot's order and `world` is the root.
    of_world = [exclude for exclude in needed if exclude.link_a == WORLD]
    of_links = [exclude for exclude in needed if exclude.link_a != WORLD]
    excludes_in_bits: list[Exclude] = []
    classes: list[list[Geom]] = []
    should_collide: _ShouldCollide = np.zeros((0, 0), np.int8)
    widened_pairs = []
    for exclude in of_world:
        geoms = exclude.geoms or tuple(_geom_pairs(exclude, geometry))
        if not geoms:
            continue
        candidates = [*excludes_in_bits, replace(exclude, geoms=geoms)]
        classified = _classes(_geoms(robot, candidates), candidates, filtered_by_mujoco)
        if len(classified[0]) > MAX_CLASSES:
            widened_pairs.append((exclude.link_a, exclude.link_b))
        else:
            excludes_in_bits, (classes, should_collide) = candidates, classified
    excluded_pairs = [*((exclude.link_a, exclude.link_b) for exclude in of_links), *widened_pairs]
    colliding_geoms = [pair for exclude in of_links for pair in _colliding_geoms(exclude, geometry)]
    return Filters(
        tuple(excluded_pairs), tuple(colliding_geoms), _bits(classes, should_collide), tuple(widened_pairs)
    )


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


def _bits(classes: Sequence[Sequence[Geom]], should_collide: _ShouldCollide) -> dict[Geom, tuple[int, int]]:
    """Returns `contype` and `conaffinity` of the geoms of all classes. `should_collide` (n, n): of the
    classes, in their order."""
    class_bits = [1 << (MAX_CLASSES - index) for index in range(len(classes))]
    bits: dict[Geom, tuple[int, int]] = {}
    for index, geoms in enumerate(classes):
        colliding = sum(
            bit for bit, should in zip(class_bits, should_collide[index], strict=True) if should >= 0
        )
        # The lowest bit is that of all geoms without a class.
        bits |= dict.fromkeys(geoms, (class_bits[index], 1 + colliding))
    return bits


def _geoms(robot: Robot, excludes: Sequence[Exclude]) -> list[Geom]:
    """Returns the geoms that the excludes name, in the order of the links."""
    index_of_link = {link.name: index for index, link in enumerate(robot.links)}
    geoms = {(exclude.link_a, a) for exclude in excludes for a, _ in exclude.geoms}
    geoms |= {(exclude.link_b, b) for exclude in excludes for _, b in exclude.geoms}
    return sorted(geoms, key=lambda geom: (index_of_link[geom[0]], geom[1]))


def _classes(
    geoms: Sequence[Geom], excludes: Sequence[Exclude], filtered_by_mujoco: FilteredPairs
) -> tuple[list[list[Geom]], _ShouldCollide]:
    """Returns few classes of geoms that should collide with the same geoms, and whether the classes should
    collide. Each geom joins the first class that fits."""
    excluded_pairs = {
        ((exclude.link_a, a), (exclude.link_b, b)) for exclude in excludes for a, b in exclude.geoms
    }

    def should_geoms_collide(first: Geom, second: Geom) -> int:
        """Returns whether two geoms should collide, as in `_ShouldCollide`."""
        if first[0] == second[0] or filtered_by_mujoco.contains(first[0], second[0]):
            return 0
        return 1 if excluded_pairs.isdisjoint(((first, second), (second, first))) else -1

    should_collide = np.array(
        [[should_geoms_collide(first, second) for second in geoms] for first in geoms], np.int8
    )
    classes = [[geom] for geom in geoms]
    index = 0
    while index < len(classes):
        candidate = index + 1
        while candidate < len(classes):
            if _are_compatible(should_collide, index, candidate):
                classes[index] += classes.pop(candidate)
                should_collide = _merged(should_collide, index, candidate)
            else:
                candidate += 1
        index += 1
    return classes, should_collide


def _are_compatible(should_collide: _ShouldCollide, index: int, other: int) -> bool:
    """Tells whether there is no class with which one of two classes should collide, and the other must
    not."""
    return bool((should_collide[index] * should_collide[other] >= 0).all())


def _merged(should_collide: _ShouldCollide, index: int, other: int) -> _ShouldCollide:
    """Returns whether classes should collide after the class `other` is merged into the compatible class
    `index`."""
    merged = should_collide.copy()
    merged[index] = np.where(merged[index] == 0, merged[other], merged[index])
    merged[:, index] = np.where(merged[:, index] == 0, merged[:, other], merged[:, index])
    return np.delete(np.delete(merged, other, axis=0), other, axis=1)
