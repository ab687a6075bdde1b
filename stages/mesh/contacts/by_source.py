"""Which shapes do not collide by what an MJCF source says: the bits of its geoms, its excludes and pairs, and
what MuJoCo leaves out by itself."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.contact.left_out import LeftOut
from linkwright.stages.robot.model.geometry import Exclude, Shape
from linkwright.stages.robot.model.mjcf_extras import MjcfElement, children_of
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.adjacency import Pair

Grid = npt.NDArray[np.bool_]
"""(n, m): which shapes of one link collide with which of another."""

Bits = tuple[tuple[int, int], ...]
"""`contype` and `conaffinity` of the colliders of a link."""


def source_excludes(robot: Robot, shapes: Sequence[Shape]) -> list[Exclude] | None:
    """The links of which none or only some of the colliders `shapes` collide; None where no two links do."""
    colliders: dict[str, list[Shape]] = {}
    for shape in shapes:
        colliders.setdefault(shape.link, []).append(shape)
    links = [link.name for link in robot.links if link.name in colliders]
    bits = {link: tuple(map(_bits, colliders[link])) for link in links}
    meet: dict[tuple[Bits, Bits], Grid] = {}
    paired = _pairs(robot, colliders)
    apart, left_out, some = excluded(robot), LeftOut(robot, _keeps_parents(robot)), False
    found = []
    for one, other in combinations(links, 2):
        kinds = bits[one], bits[other]
        if kinds not in meet:
            meet[kinds] = _meet(*kinds)
        may = meet[kinds].copy()
        if left_out.contains(one, other) or frozenset((one, other)) in apart:
            may[:] = False
        for a, b in paired.get((one, other), ()):
            may[a, b] = True
        some = some or bool(may.any())
        if not may.all():
            geoms = () if not may.any() else tuple((int(a), int(b)) for a, b in np.argwhere(~may))
            found.append(Exclude(one, other, "Source", 0.0, geoms))
    return found if some else None


def _bits(shape: Shape) -> tuple[int, int]:
    contact = shape.form.contact
    own = (None, None) if contact is None else (contact.contype, contact.conaffinity)
    return 1 if own[0] is None else own[0], 1 if own[1] is None else own[1]


def _meet(one: Bits, other: Bits) -> Grid:
    """By MuJoCo's rule: the bits of two geoms have one in common, either way round."""
    a, b = (np.array(bits) for bits in (one, other))
    met: Grid = (a[:, None, 0] & b[None, :, 1] | b[None, :, 0] & a[:, None, 1]) != 0
    return met


def _contacts(robot: Robot, tag: str) -> Iterator[MjcfElement]:
    sections = robot.mjcf.sections if robot.mjcf is not None else ()
    return (element for element in children_of(sections, "contact") if element.tag == tag)


def excluded(robot: Robot) -> set[frozenset[str]]:
    """The pairs of links that the excludes of an MJCF source name."""
    return {frozenset(name for _, name in exclude.named()) for exclude in _contacts(robot, "exclude")}


def _keeps_parents(robot: Robot) -> bool:
    """Whether MuJoCo leaves out a body and the one that it hangs on."""
    return robot.mjcf is None or dict(robot.mjcf.flag).get("filterparent") != "disable"


def _pairs(robot: Robot, colliders: Mapping[str, Sequence[Shape]]) -> dict[Pair, list[tuple[int, int]]]:
    """By two links: the positions among their colliders of geoms that collide whatever their bits say."""
    place = {link.name: index for index, link in enumerate(robot.links)}
    named = {
        shape.form.name: (place[link], link, index)
        for link, every in colliders.items()
        for index, shape in enumerate(every)
        if shape.form.name
    }
    found: dict[Pair, list[tuple[int, int]]] = {}
    for pair in _contacts(robot, "pair"):
        ends = sorted(named[name] for _, name in pair.named() if name in named)
        if len(ends) == 2:
            (_, one, a), (_, other, b) = ends
            found.setdefault((one, other), []).append((a, b))
    return found
