"""The shapes of a robot whose links on fixed joints are part of others."""

from dataclasses import dataclass, replace
from itertools import product

from linkwright.stages.robot.dynamics.fusing import Holders, members
from linkwright.stages.robot.model.geometry import Exclude, Geometry, Shape, Touch
from linkwright.stages.robot.model.robot import Robot


@dataclass(frozen=True, slots=True)
class _Colliders:
    """The collision shapes of a link: the first of them among those of its holder, and how many they are."""

    holder: str
    first: int
    count: int


def fused_geometry(robot: Robot, geometry: Geometry, held: Holders) -> Geometry:
    """The shapes, excludes and contacts by the holders of the links. A mesh stays in the frame of its own
    link: this says which shapes a body has, and in which order, not where they are."""
    groups = members(robot, held)
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
            own = by_link.get(link, [])
            shapes += [replace(shape, link=holder) for shape in own]
            count = sum(shape.role == "collision" for shape in own)
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
    """One for each two holders: of them as a whole where all of their shapes are apart."""
    order = {holder: index for index, holder in enumerate(totals)}
    found: dict[tuple[str, str], Exclude] = {}
    for one in geometry.excludes:
        a, b = colliders[one.link_a], colliders[one.link_b]
        if a.holder == b.holder:
            continue
        pairs = one.geoms or product(range(a.count), range(b.count))
        apart = {(a.first + i, b.first + j) for i, j in pairs}
        if order[a.holder] > order[b.holder]:
            a, b, apart = b, a, {(j, i) for i, j in apart}
        before = found.get((a.holder, b.holder))
        if before is not None:
            apart |= set(before.geoms)
            one = replace(one, reason=before.reason, depth=max(one.depth, before.depth))
        found[a.holder, b.holder] = Exclude(a.holder, b.holder, one.reason, one.depth, tuple(sorted(apart)))
    whole = []
    for (a_name, b_name), one in sorted(found.items(), key=lambda item: [order[name] for name in item[0]]):
        every = totals[a_name] * totals[b_name]
        if one.geoms or not every:
            whole.append(replace(one, geoms=()) if len(one.geoms) == every else one)
    return tuple(whole)


def _touching(
    geometry: Geometry, colliders: dict[str, _Colliders], totals: dict[str, int]
) -> tuple[Touch, ...]:
    order = {holder: index for index, holder in enumerate(totals)}
    found: dict[tuple[str, str], float] = {}
    for one in geometry.touching:
        a, b = sorted((colliders[link].holder for link in (one.link_a, one.link_b)), key=order.__getitem__)
        if a != b:
            found[a, b] = max(one.depth, found.get((a, b), 0.0))
    return tuple(Touch(a, b, depth) for (a, b), depth in found.items())
