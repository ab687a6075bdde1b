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

ALL_BITS = 0xFFFF
"""The bits of a mask that Gazebo keeps."""

DEFAULT_MASK = 0xFF
"""The mask of a collider that has no mask in the file."""

MAX_EXCLUDED_LINKS = 8
"""The bits of `DEFAULT_MASK` are always enough if at most this many links are in pairs that must not collide.
With more links, no links of the SDF may collide with each other (I-SDF-SELF)."""

MASK_PATH = "surface contact collide_bitmask"
"""The path of the mask in a collision."""


def contact_findings(model: SdfModel, sdf_names: Mapping[str, str], geometry: Geometry) -> list[Finding]:
    """Checks that the links collide with each other as in the robot, and that every collider collides with
    colliders without a mask. `sdf_names`: link of the robot → its name in the SDF."""
    findings = [finding for link in model.links.values() for finding in _world_findings(link)]
    return [*findings, *_self_contact_findings(model, sdf_names, geometry)]


def _world_findings(link: SdfLink) -> Iterator[Finding]:
    """Yields the colliders of a link that do not collide with colliders without a mask, as the world's
    are."""
    for number, shape in enumerate(link.collisions, 1):
        if not shape.pushed:
            message = "lets everything pass through it"
            yield Finding(named("link", link.name), f"collision {number} surface contact", message)
        elif not _mask(shape) & DEFAULT_MASK:
            message = f"shares no bit with {DEFAULT_MASK}, which a collider without a mask has"
            yield Finding(named("link", link.name), f"collision {number} {MASK_PATH}", message)


def _self_contact_findings(
    model: SdfModel, sdf_names: Mapping[str, str], geometry: Geometry
) -> Iterator[Finding]:
    """Yields links that collide but must not, and links that must collide but do not. `sdf_names`: link of
    the robot → its name in the SDF."""
    # Gazebo never lets links collide that a joint of the tree connects.
    joined = _joined_pairs(model, sdf_names)
    sdf_links = {link: model.links[sdf_name] for link, sdf_name in sdf_names.items()}
    excluded = {
        (exclude.link_a, exclude.link_b): exclude.geoms
        for exclude in geometry.excludes
        if frozenset((exclude.link_a, exclude.link_b)) not in joined
    }
    if not geometry.self_contact:
        elements = [named("link", link.name) for link in sdf_links.values() if link.self_collides]
        elements += [named("model", model.name)] if model.self_collides else []
        yield from (differs(element, "self_collide", "true", "false") for element in elements)
    elif not model.self_collides:
        if len({name for pair in excluded for name in pair}) <= MAX_EXCLUDED_LINKS:
            yield differs(named("model", model.name), "self_collide", "false", "true")
    else:
        # Colliders without a mask collide with each other, and `_world_findings` checks all others with them.
        masked_links = [
            name
            for name, link in sdf_links.items()
            if any(shape.mask is not None for shape in link.collisions)
        ]
        # Both names of a pair are in the order of the robot's links, as in excludes.
        for pair in sorted({*combinations(masked_links, 2), *excluded}):
            if frozenset(pair) not in joined:
                pair_of_links = [sdf_links[name] for name in pair]
                yield from _pair_findings(pair_of_links, excluded.get(pair), _uses_all_bits(model))


def _pair_findings(
    links: Sequence[SdfLink], excluded: Sequence[tuple[int, int]] | None, uses_all_bits: bool
) -> Iterator[Finding]:
    """Compares two links. `excluded`: the positions of colliders that must not collide, () for all, None if
    all must collide. `uses_all_bits`: whether no bit is left, so that some pairs that should collide may not
    (I-SDF-SELF)."""
    first, second = ([_mask(shape) for shape in link.collisions] for link in links)
    collide = np.bitwise_and.outer(np.array(first, dtype=int), np.array(second, dtype=int)) != 0
    expected = np.ones_like(collide)
    for row, column in excluded or ():
        expected[row, column] = False
    if excluded == ():
        expected[...] = False
    names = " and ".join(link.name for link in links)
    if (collide & ~expected).any():
        yield Finding(
            named("link", links[0].name),
            f"collision {MASK_PATH}",
            f"colliders of {names} collide, but must not",
        )
    elif (expected & ~collide).any() and not uses_all_bits:
        yield Finding(
            named("link", links[0].name),
            f"collision {MASK_PATH}",
            f"colliders of {names} do not collide, but must",
        )


def _joined_pairs(model: SdfModel, sdf_names: Mapping[str, str]) -> set[frozenset[str]]:
    """Returns the pairs of the robot's links that the tree joins: a link and its parent. Of several joints
    with the same child, the first counts."""
    link_of_sdf_name = {sdf_name: link for link, sdf_name in sdf_names.items()}
    parent_of: dict[str, str] = {}
    for joint in model.joints.values():
        parent_of.setdefault(joint.child, joint.parent)
    return {
        frozenset((link_of_sdf_name[child], link_of_sdf_name[parent]))
        for child, parent in parent_of.items()
        if {child, parent} <= link_of_sdf_name.keys()
    }


def _uses_all_bits(model: SdfModel) -> bool:
    """Tells whether each bit that Gazebo keeps is in a mask of the file."""
    masks = [
        shape.mask for link in model.links.values() for shape in link.collisions if shape.mask is not None
    ]
    return reduce(or_, masks, 0) & ALL_BITS == ALL_BITS


def _mask(shape: SdfShape) -> int:
    """Returns the mask of a collider as Gazebo keeps it."""
    return (DEFAULT_MASK if shape.mask is None else shape.mask) & ALL_BITS
