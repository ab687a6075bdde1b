"""Checks which colliders of an SDF collide, as Gazebo reads their masks (gz-physics with DART)."""

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

ALL_BITS, DEFAULT_MASK = 0xFFFF, 0xFF
"""The bits of a mask that Gazebo keeps, and the mask of a collider that has no mask in the file."""

MAX_LINKS = 8
"""Largest number of links, in pairs that must not collide, for which the bits of `DEFAULT_MASK` are enough.
With more links, no links of the SDF may collide with each other (I-SDF-SELF)."""

MASK_PATH = "surface contact collide_bitmask"


def contacts(model: SdfModel, links: Mapping[str, str], geometry: Geometry) -> list[Finding]:
    """Checks that the links collide with each other as in the robot, and that every collider collides with
    colliders without a mask. `links`: link of the robot → its name in the SDF."""
    outside = [finding for link in model.links.values() for finding in _outside(link)]
    return [*outside, *_together(model, links, geometry)]


def _outside(link: SdfLink) -> Iterator[Finding]:
    """Reports masks that keep a link's colliders from colliding with the world."""
    for number, shape in enumerate(link.collisions, 1):
        if not shape.pushed:
            message = "lets all pass through it"
            yield Finding(named("link", link.name), f"collision {number} surface contact", message)
        elif not _mask(shape) & DEFAULT_MASK:
            message = f"shares no bit with {DEFAULT_MASK}, which a collider without a mask has"
            yield Finding(named("link", link.name), f"collision {number} {MASK_PATH}", message)


def _together(model: SdfModel, names: Mapping[str, str], geometry: Geometry) -> Iterator[Finding]:
    """Reports links that collide but must not, and links that must collide but do not."""
    joined, links = _joined_pairs(model, names), {name: model.links[title] for name, title in names.items()}
    excluded = {(exclude.link_a, exclude.link_b): exclude.geoms for exclude in geometry.excludes}
    excluded = {pair: geoms for pair, geoms in excluded.items() if frozenset(pair) not in joined}
    if not geometry.self_contact:
        wrong = [named("link", link.name) for link in links.values() if link.self_collides]
        wrong += [named("model", model.name)] if model.self_collides else []
        yield from (differs(element, "self_collide", "true", "false") for element in wrong)
    elif not model.self_collides:
        if len({name for pair in excluded for name in pair}) <= MAX_LINKS:
            yield differs(named("model", model.name), "self_collide", "false", "true")
    else:
        masked = [
            name for name, link in links.items() if any(shape.mask is not None for shape in link.collisions)
        ]
        for pair in sorted({*combinations(masked, 2), *excluded}):
            if frozenset(pair) not in joined:
                yield from _pair([links[name] for name in pair], excluded.get(pair), _full(model))


def _pair(
    links: Sequence[SdfLink], excluded: Sequence[tuple[int, int]] | None, full: bool
) -> Iterator[Finding]:
    """Compares two links. `excluded`: the positions of colliders that must not collide, () for all, None if
    all must collide. `full`: whether all bits are in use, so that some pairs that should collide may not
    (I-SDF-SELF)."""
    first, second = ([_mask(shape) for shape in link.collisions] for link in links)
    collide = np.bitwise_and.outer(np.array(first, dtype=int), np.array(second, dtype=int)) != 0
    expected = np.ones_like(collide)
    for a, b in excluded or ():
        expected[a, b] = False
    if excluded == ():
        expected[...] = False
    names = " and ".join(link.name for link in links)
    if (collide & ~expected).any():
        yield Finding(
            named("link", links[0].name),
            f"collision {MASK_PATH}",
            f"colliders of {names} collide, but must not",
        )
    elif (expected & ~collide).any() and not full:
        yield Finding(
            named("link", links[0].name),
            f"collision {MASK_PATH}",
            f"colliders of {names} do not collide, but must",
        )


def _joined_pairs(model: SdfModel, names: Mapping[str, str]) -> set[frozenset[str]]:
    """Returns the pairs of the robot's links that are joined by the first joint that holds a link."""
    name = {title: link for link, title in names.items()}
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
    return reduce(or_, masks, 0) & ALL_BITS == ALL_BITS


def _mask(shape: SdfShape) -> int:
    return (DEFAULT_MASK if shape.mask is None else shape.mask) & ALL_BITS
