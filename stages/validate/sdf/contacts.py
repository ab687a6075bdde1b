"""The check of which colliders of an SDF collide, as Gazebo reads their masks (gz-physics with DART)."""

from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from itertools import combinations
from operator import or_

import numpy as np

from linkwright.stages.formats.sdf.model import SdfLink, SdfModel
from linkwright.stages.formats.sdf.shapes import SdfShape
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.validate.findings import differs, named

ALL, DEFAULT = 0xFFFF, 0xFF
"""The bits of a mask that Gazebo keeps, and the mask of a collider that has none in the file."""

FEW = 8
"""Where more links than `DEFAULT` has bits are in pairs that must not collide, these may be too few; then the
links of the SDF do not collide with each other at all (I-SDF-SELF)."""

MASK = "surface contact collide_bitmask"


def contacts(model: SdfModel, links: Mapping[str, str], geometry: Geometry) -> list[Finding]:
    """The links collide with each other as in the robot, and every collider with what has no mask. `links`:
    the names in the SDF of the robot's links."""
    found = [finding for link in model.links.values() for finding in _outside(link)]
    return [*found, *_together(model, links, geometry)]


def _outside(link: SdfLink) -> Iterator[Finding]:
    """What keeps a link's colliders from colliding with the world."""
    for number, shape in enumerate(link.collisions, 1):
        if not shape.pushed:
            words = "lets all pass through it"
            yield Finding(named("link", link.name), f"collision {number} surface contact", words)
        elif not _mask(shape) & DEFAULT:
            words = f"shares no bit with {DEFAULT}, which a collider without a mask has"
            yield Finding(named("link", link.name), f"collision {number} {MASK}", words)


def _together(model: SdfModel, names: Mapping[str, str], geometry: Geometry) -> Iterator[Finding]:
    """What collides of the robot's links that must not, or does not and must."""
    joined, links = _joined(model, names), {name: model.links[own] for name, own in names.items()}
    apart = {(one.link_a, one.link_b): one.geoms for one in geometry.excludes}
    apart = {pair: geoms for pair, geoms in apart.items() if frozenset(pair) not in joined}
    if not geometry.self_contact:
        wrong = [named("link", link.name) for link in links.values() if link.self_collides]
        wrong += [named("model", model.name)] if model.self_collides else []
        yield from (differs(element, "self_collide", "true", "false") for element in wrong)
    elif not model.self_collides:
        if len({name for pair in apart for name in pair}) <= FEW:
            yield differs(named("model", model.name), "self_collide", "false", "true")
    else:
        masked = [
            name for name, link in links.items() if any(shape.mask is not None for shape in link.collisions)
        ]
        for pair in sorted({*combinations(masked, 2), *apart}):
            if frozenset(pair) not in joined:
                yield from _pair([links[name] for name in pair], apart.get(pair), _full(model))


def _pair(links: Sequence[SdfLink], apart: Sequence[tuple[int, int]] | None, full: bool) -> Iterator[Finding]:
    """`apart`: positions of colliders that must not collide, () for all, None where there are none; `full`:
    whether all bits are taken, so that some may not collide that should (I-SDF-SELF)."""
    first, second = ([_mask(shape) for shape in link.collisions] for link in links)
    collide = np.bitwise_and.outer(np.array(first, dtype=int), np.array(second, dtype=int)) != 0
    wanted = np.ones_like(collide)
    for a, b in apart or ():
        wanted[a, b] = False
    if apart == ():
        wanted[...] = False
    names = " and ".join(link.name for link in links)
    if (collide & ~wanted).any():
        yield Finding(
            named("link", links[0].name), f"collision {MASK}", f"colliders of {names} collide, but must not"
        )
    elif (wanted & ~collide).any() and not full:
        yield Finding(
            named("link", links[0].name),
            f"collision {MASK}",
            f"colliders of {names} do not collide, but must",
        )


def _joined(model: SdfModel, names: Mapping[str, str]) -> set[frozenset[str]]:
    """The robot's links that a joint of the tree joins: the first joint that a link hangs on."""
    name = {own: link for link, own in names.items()}
    tree: dict[str, str] = {}
    for joint in model.joints.values():
        tree.setdefault(joint.child, joint.parent)
    return {
        frozenset((name[child], name[parent]))
        for child, parent in tree.items()
        if {child, parent} <= name.keys()
    }


def _full(model: SdfModel) -> bool:
    masks = [
        shape.mask for link in model.links.values() for shape in link.collisions if shape.mask is not None
    ]
    return reduce(or_, masks, 0) & ALL == ALL


def _mask(shape: SdfShape) -> int:
    return (DEFAULT if shape.mask is None else shape.mask) & ALL
