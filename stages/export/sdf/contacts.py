"""Which colliders of an SDF collide, by `collide_bitmask`: two do whose masks have a bit in common.

That is how Gazebo reads it (gz-physics with DART), which knows 16 bits and leaves out links joined by a joint
by itself. A collider without a mask collides with all; for Gazebo it has the low eight bits, so each mask has
one of these. Colliders of which some must not collide are in sets of such as may, each two that must collide
together in one of them: a set is a bit.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from linkwright.stages.robot.model.geometry import Exclude, Geometry
from linkwright.stages.robot.motion.adjacency import Pair

BITS, LOW = 16, 8
"""The bits of a mask, and those that everything without a mask has."""

Collider = tuple[str, int]
"""A link, and a position among its collision shapes."""


@dataclass(frozen=True, slots=True)
class SdfContacts:
    """`collides`: whether the links collide with each other; `masks`: of the colliders that do not collide
    with all others; `lost`: pairs of links that do not collide though they should, as bits are lacking."""

    collides: bool
    masks: Mapping[Collider, int]
    lost: tuple[Pair, ...] = ()


def sdf_contacts(geometry: Geometry, joined: Collection[frozenset[str]]) -> SdfContacts:
    """`joined`: the pairs of links that a joint of the SDF joins."""
    apart = [one for one in geometry.excludes if frozenset((one.link_a, one.link_b)) not in joined]
    if not geometry.self_contact or not apart:
        return SdfContacts(geometry.self_contact, {})
    partners = _partners(geometry, apart)
    groups = _groups(partners)
    links = [colliders[0][0] for colliders in groups]
    number_of = {collider: number for number, colliders in enumerate(groups) for collider in colliders}
    foes = [{number_of[partner] for partner in partners[colliders[0]]} for colliders in groups]
    friends = [
        {
            other
            for other, link in enumerate(links)
            if link != links[number]
            and other not in foes[number]
            and frozenset((link, links[number])) not in joined
        }
        for number in range(len(groups))
    ]
    sets = _sets(foes, friends)
    if len(set().union(*sets[:LOW])) < len(groups):
        return SdfContacts(False, {})
    lost = [
        (links[one], links[other])
        for one, left in enumerate(friends)
        for other in sorted(left)
        if one < other
    ]
    masks = {
        collider: sum(1 << bit for bit, members in enumerate(sets) if number in members)
        for collider, number in number_of.items()
    }
    return SdfContacts(True, masks, tuple(dict.fromkeys(lost)))


def _partners(geometry: Geometry, apart: Sequence[Exclude]) -> dict[Collider, set[Collider]]:
    """Each collider that must not collide with some → these."""
    shapes = geometry.by_link()
    partners: dict[Collider, set[Collider]] = {}
    for exclude in apart:
        a, b = exclude.link_a, exclude.link_b
        every = product(*(range(len(shapes[link, "collision"])) for link in (a, b)))
        for i, j in exclude.geoms or every:
            partners.setdefault((a, i), set()).add((b, j))
            partners.setdefault((b, j), set()).add((a, i))
    return partners


def _groups(partners: Mapping[Collider, set[Collider]]) -> list[list[Collider]]:
    """The colliders of one link that must not collide with the same ones, together."""
    groups: dict[tuple[str, frozenset[Collider]], list[Collider]] = {}
    for collider in sorted(partners):
        groups.setdefault((collider[0], frozenset(partners[collider])), []).append(collider)
    return list(groups.values())


def _sets(foes: Sequence[Collection[int]], friends: Sequence[set[int]]) -> list[set[int]]:
    """At most as many sets of groups as there are bits, none with two foes: first those that together have
    each group, then those that together have each two friends. Each grows by the group that adds the most of
    these. Takes the friends that are together in a set out of `friends`."""
    sets: list[set[int]] = []
    alone = dict.fromkeys(range(len(foes)))
    while len(sets) < BITS and (alone or any(friends)):
        first = next(iter(alone)) if alone else next(one for one, left in enumerate(friends) if left)
        members: set[int] = set()
        gains = {number: int(number in alone) for number in range(len(foes))}
        best: int | None = first
        while best is not None:
            members.add(best)
            for number in (best, *foes[best]):
                gains.pop(number, None)
            for number in friends[best] & gains.keys():
                gains[number] += 1
            best = max(gains, key=lambda number: gains[number], default=None)
            if best is not None and not gains[best]:
                best = None
        sets.append(members)
        for number in members:
            alone.pop(number, None)
            friends[number] -= members
    return sets
