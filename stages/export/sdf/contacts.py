"""Chooses masks (`collide_bitmask`) for colliders of an SDF: two collide if their masks have a bit in common.

Gazebo (gz-physics with DART) reads 16 bits of a mask, and by itself excludes links that a joint joins. A
collider without a mask has the low eight bits in Gazebo. It collides with all others, so each mask has one of
these bits. If some colliders must not collide, their masks are made of sets of colliders, one bit for each
set: no set has two that must not collide, and each two that must collide are together in a set.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from linkwright.stages.robot.model.geometry import Exclude, Geometry
from linkwright.stages.robot.motion.adjacency import Pair

MASK_BITS = 16
"""Number of bits of a mask."""

DEFAULT_BITS = 8
"""Number of the low bits that a collider without a mask has."""

Collider = tuple[str, int]
"""(link, index among its collision shapes)."""


@dataclass(frozen=True, slots=True)
class SdfContacts:
    """The contacts between the links of an SDF."""

    collides: bool
    """Whether the links collide with each other."""

    masks: Mapping[Collider, int]
    """The masks of the colliders that do not collide with all others."""

    lost: tuple[Pair, ...] = ()
    """The pairs of links that should collide and do not, since the bits do not suffice."""


def sdf_contacts(geometry: Geometry, joined: Collection[frozenset[str]]) -> SdfContacts:
    """Returns the contacts of an SDF. `joined`: the pairs of links that a joint of the SDF joins."""
    excludes = [
        exclude for exclude in geometry.excludes if frozenset((exclude.link_a, exclude.link_b)) not in joined
    ]
    if not geometry.self_contact or not excludes:
        return SdfContacts(geometry.self_contact, {})
    partners = _partners(geometry, excludes)
    groups = _groups(partners)
    # The link of each group, by its index.
    links = [colliders[0][0] for colliders in groups]
    group_of = {collider: group for group, colliders in enumerate(groups) for collider in colliders}
    # For each group, the groups with which it must not collide (foes), and must collide (friends).
    foes = [{group_of[partner] for partner in partners[colliders[0]]} for colliders in groups]
    friends = [
        {
            other
            for other, link in enumerate(links)
            if link != links[group]
            and other not in foes[group]
            and frozenset((link, links[group])) not in joined
        }
        for group in range(len(groups))
    ]
    sets = _sets(foes, friends)
    # Without one of the low bits, a collider would not collide with those that have no mask.
    if len(set().union(*sets[:DEFAULT_BITS])) < len(groups):
        return SdfContacts(False, {})
    lost = [
        (links[group], links[other])
        for group, lost_friends in enumerate(friends)
        for other in sorted(lost_friends)
        if group < other
    ]
    masks = {
        collider: sum(1 << bit for bit, members in enumerate(sets) if group in members)
        for collider, group in group_of.items()
    }
    return SdfContacts(True, masks, tuple(dict.fromkeys(lost)))


def _partners(geometry: Geometry, excludes: Sequence[Exclude]) -> dict[Collider, set[Collider]]:
    """Returns the colliders with which each collider must not collide."""
    shapes = geometry.by_link()
    partners: dict[Collider, set[Collider]] = {}
    for exclude in excludes:
        a, b = exclude.link_a, exclude.link_b
        all_pairs = product(*(range(len(shapes[link, "collision"])) for link in (a, b)))
        for i, j in exclude.geoms or all_pairs:
            partners.setdefault((a, i), set()).add((b, j))
            partners.setdefault((b, j), set()).add((a, i))
    return partners


def _groups(partners: Mapping[Collider, set[Collider]]) -> list[list[Collider]]:
    """Groups the colliders of a link that must not collide with the same colliders."""
    groups: dict[tuple[str, frozenset[Collider]], list[Collider]] = {}
    for collider in sorted(partners):
        groups.setdefault((collider[0], frozenset(partners[collider])), []).append(collider)
    return list(groups.values())


def _sets(foes: Sequence[Collection[int]], friends: Sequence[set[int]]) -> list[set[int]]:
    """Returns sets of groups, at most as many as a mask has bits, none with two foes. The first sets together
    contain each group; the later sets unite each two friends. A set grows greedily: it gets the group that is
    in no set yet or has the most friends in it. Removes from `friends` the pairs that a set unites."""
    sets: list[set[int]] = []
    unplaced = dict.fromkeys(range(len(foes)))
    while len(sets) < MASK_BITS and (unplaced or any(friends)):
        first = (
            next(iter(unplaced)) if unplaced else next(group for group, left in enumerate(friends) if left)
        )
        members: set[int] = set()
        gains = {group: int(group in unplaced) for group in range(len(foes))}
        best: int | None = first
        while best is not None:
            members.add(best)
            for group in (best, *foes[best]):
                gains.pop(group, None)
            for group in friends[best] & gains.keys():
                gains[group] += 1
            best = max(gains, key=lambda group: gains[group], default=None)
            if best is not None and not gains[best]:
                best = None
        sets.append(members)
        for group in members:
            unplaced.pop(group, None)
            friends[group] -= members
    return sets
