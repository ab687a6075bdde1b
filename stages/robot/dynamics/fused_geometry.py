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
    first: int
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
        a, b = colliders[exclude.link_a], colliders[exclude.link_b]
        if a.holder == b.holder:
            continue
        pairs = exclude.geoms or product(range(a.count), range(b.count))
        geom_pairs = {(a.first + i, b.first + j) for i, j in pairs}
        if order[a.holder] > order[b.holder]:
            a, b, geom_pairs = b, a, {(j, i) for i, j in geom_pairs}
        previous = by_holders.get((a.holder, b.holder))
        if previous is not None:
            geom_pairs |= set(previous.geoms)
            exclude = replace(exclude, reason=previous.reason, depth=max(exclude.depth, previous.depth))
        by_holders[a.holder, b.holder] = Exclude(
            a.holder, b.holder, exclude.reason, exclude.depth, tuple(sorted(geom_pairs))
        )
    merged = []
    for (a_name, b_name), exclude in sorted(
        by_holders.items(), key=lambda item: [order[name] for name in item[0]]
    ):
        pair_count = totals[a_name] * totals[b_name]
        if exclude.geoms or not pair_count:
            merged.append(replace(exclude, geoms=()) if len(exclude.geoms) == pair_count else exclude)
    return tuple(merged)


def _touching(
    geometry: Geometry, colliders: dict[str, _Colliders], totals: dict[str, int]
) -> tuple[Touch, ...]:
    order = {holder: index for index, holder in enumerate(totals)}
    depths: dict[tuple[str, str], float] = {}
    for touch in geometry.touching:
        a, b = sorted(
            (colliders[link].holder for link in (touch.link_a, touch.link_b)), key=order.__getitem__
        )
        if a != b:
            depths[a, b] = max(touch.depth, depths.get((a, b), 0.0))
    return tuple(Touch(a, b, depth) for (a, b), depth in depths.items())
