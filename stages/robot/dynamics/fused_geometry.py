"""Moves the shapes of fused links to the links that hold them."""

from dataclasses import dataclass, replace
from itertools import product

from linkwright.stages.robot.dynamics.fusing import Holders, members
from linkwright.stages.robot.model.geometry import Exclude, Geometry, Shape, Touch
from linkwright.stages.robot.model.robot import Robot


@dataclass(frozen=True, slots=True)
class _Colliders:
    """The place of a link's collision shapes among those of its holder."""

    holder: str
    start: int
    """Index of the link's first collision shape among those of its holder."""
    count: int
    """Number of the link's collision shapes."""


def fused_geometry(robot: Robot, geometry: Geometry, holders: Holders) -> Geometry:
    """Returns the geometry whose shapes, excludes and touching pairs are those of the links' holders. The
    shapes of a holder are in the order of its links, but a shape stays in the frame of its own link."""
    groups = members(robot, holders)
    if len(groups) == len(robot.links):
        return geometry
    by_link: dict[str, list[Shape]] = {}
    for shape in geometry.shapes:
        by_link.setdefault(shape.link, []).append(shape)
    shapes: list[Shape] = []
    colliders: dict[str, _Colliders] = {}
    totals: dict[str, int] = {}
    for holder, group in groups.items():
        total = 0
        for link, _ in group:
            link_shapes = by_link.get(link, [])
            shapes += [replace(shape, link=holder) for shape in link_shapes]
            count = sum(shape.role == "collision" for shape in link_shapes)
            colliders[link] = _Colliders(holder, total, count)
            total += count
        totals[holder] = total
    return replace(
        geometry,
        shapes=tuple(shapes),
        excludes=_excludes(geometry, colliders, totals),
        touching=_touching(geometry, colliders, totals),
    )


def _excludes(
    geometry: Geometry, colliders: dict[str, _Colliders], totals: dict[str, int]
) -> tuple[Exclude, ...]:
    """Returns the exclude of each two holders: one of whole links if no pair of their shapes collides, else
    one of pairs of shapes, left out without such a pair."""
    order = {holder: index for index, holder in enumerate(totals)}
    by_holders: dict[tuple[str, str], Exclude] = {}
    for exclude in geometry.excludes:
        first, second = colliders[exclude.link_a], colliders[exclude.link_b]
        if first.holder == second.holder:
            continue
        pairs = exclude.geoms or product(range(first.count), range(second.count))
        geom_pairs = {(first.start + i, second.start + j) for i, j in pairs}
        if order[first.holder] > order[second.holder]:
            first, second, geom_pairs = second, first, {(j, i) for i, j in geom_pairs}
        holders = (first.holder, second.holder)
        previous = by_holders.get(holders)
        if previous is not None:
            geom_pairs |= set(previous.geoms)
            exclude = replace(exclude, reason=previous.reason, depth=max(exclude.depth, previous.depth))
        by_holders[holders] = Exclude(
            *holders, exclude.reason, exclude.depth, geoms=tuple(sorted(geom_pairs))
        )
    merged = []
    for holders, exclude in sorted(
        by_holders.items(), key=lambda item: [order[holder] for holder in item[0]]
    ):
        pair_count = totals[holders[0]] * totals[holders[1]]
        if len(exclude.geoms) == pair_count:
            # All pairs of shapes, or no shapes at all: whole links.
            merged.append(replace(exclude, geoms=()))
        elif exclude.geoms:
            merged.append(exclude)
    return tuple(merged)


def _touching(
    geometry: Geometry, colliders: dict[str, _Colliders], totals: dict[str, int]
) -> tuple[Touch, ...]:
    """Returns the touching pairs of holders, each with the largest penetration of their links."""
    order = {holder: index for index, holder in enumerate(totals)}
    depths: dict[tuple[str, str], float] = {}
    for touch in geometry.touching:
        holders = {colliders[touch.link_a].holder, colliders[touch.link_b].holder}
        if len(holders) == 2:
            first, second = sorted(holders, key=order.__getitem__)
            depths[first, second] = max(touch.depth, depths.get((first, second), 0.0))
    return tuple(Touch(first, second, depth) for (first, second), depth in depths.items())
