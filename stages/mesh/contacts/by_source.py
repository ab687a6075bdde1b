"""Finds the colliders that do not collide in an MJCF source: by the bits of its geoms, by its excludes and
pairs, and by MuJoCo's rule for a body and its parent."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.contact.left_out import FilteredPairs
from linkwright.stages.robot.model.geometry import Exclude, Shape
from linkwright.stages.robot.model.mjcf_extras import MjcfElement, children_of
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.adjacency import Pair

Grid = npt.NDArray[np.bool_]
"""Whether each collider of a link collides with each collider of another link (n, m)."""

Bits = tuple[tuple[int, int], ...]
"""`contype` and `conaffinity` of the colliders of a link."""


def source_excludes(robot: Robot, shapes: Sequence[Shape]) -> list[Exclude] | None:
    """Returns the excludes of all pairs of links whose colliders (`shapes`) do not all collide with each
    other; None if no two links collide."""
    colliders: dict[str, list[Shape]] = {}
    for shape in shapes:
        colliders.setdefault(shape.link, []).append(shape)
    links = [link.name for link in robot.links if link.name in colliders]
    bits = {link: tuple(map(_bits, colliders[link])) for link in links}
    grid_of: dict[tuple[Bits, Bits], Grid] = {}
    paired = _pairs(robot, colliders)
    excluded_links = excluded_by_source(robot)
    left_out_by_rule = FilteredPairs(robot, _leaves_out_parents(robot))
    any_collides = False
    excludes = []
    for first, second in combinations(links, 2):
        bit_pair = bits[first], bits[second]
        if bit_pair not in grid_of:
            grid_of[bit_pair] = _collision_grid(*bit_pair)
        colliding = grid_of[bit_pair].copy()
        if left_out_by_rule.contains(first, second) or frozenset((first, second)) in excluded_links:
            colliding[:] = False
        for a, b in paired.get((first, second), ()):
            colliding[a, b] = True
        any_collides = any_collides or bool(colliding.any())
        if not colliding.all():
            geoms = () if not colliding.any() else tuple((int(a), int(b)) for a, b in np.argwhere(~colliding))
            excludes.append(Exclude(first, second, "Source", 0.0, geoms))
    return excludes if any_collides else None


def _bits(shape: Shape) -> tuple[int, int]:
    contact = shape.form.contact
    contype, conaffinity = (None, None) if contact is None else (contact.contype, contact.conaffinity)
    # MuJoCo's default is 1 for both.
    return 1 if contype is None else contype, 1 if conaffinity is None else conaffinity


def _collision_grid(first: Bits, second: Bits) -> Grid:
    """Tells which geoms collide by MuJoCo's rule: `contype` of either shares a bit with the other's
    `conaffinity`."""
    a, b = (np.array(bits) for bits in (first, second))
    grid: Grid = (a[:, None, 0] & b[None, :, 1] | b[None, :, 0] & a[:, None, 1]) != 0
    return grid


def _contacts(robot: Robot, tag: str) -> Iterator[MjcfElement]:
    sections = robot.mjcf.sections if robot.mjcf is not None else ()
    return (element for element in children_of(sections, "contact") if element.tag == tag)


def excluded_by_source(robot: Robot) -> set[frozenset[str]]:
    """Returns the pairs of links that the excludes of an MJCF source name. MuJoCo also accepts an exclude of
    a body with itself, which is no pair."""
    pairs = {frozenset(name for _, name in exclude.named()) for exclude in _contacts(robot, "exclude")}
    return {pair for pair in pairs if len(pair) == 2}


def _leaves_out_parents(robot: Robot) -> bool:
    """Tells whether MuJoCo leaves out contact of a body with its parent."""
    return robot.mjcf is None or dict(robot.mjcf.flag).get("filterparent") != "disable"


def _pairs(robot: Robot, colliders: Mapping[str, Sequence[Shape]]) -> dict[Pair, list[tuple[int, int]]]:
    """Returns the geoms that the source's pairs let collide, whatever their bits: for two links, indices
    among the colliders of each."""
    position = {link.name: index for index, link in enumerate(robot.links)}
    colliders_by_name = {
        shape.form.name: (position[link], link, index)
        for link, shapes in colliders.items()
        for index, shape in enumerate(shapes)
        if shape.form.name
    }
    paired: dict[Pair, list[tuple[int, int]]] = {}
    for pair in _contacts(robot, "pair"):
        ends = sorted(colliders_by_name[name] for _, name in pair.named() if name in colliders_by_name)
        if len(ends) == 2:
            (_, first, a), (_, second, b) = ends
            paired.setdefault((first, second), []).append((a, b))
    return paired
