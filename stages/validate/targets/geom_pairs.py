"""Finds the geoms of a compiled model that may touch."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

from linkwright.stages.validate.contact_errors import never_collide


@dataclass(frozen=True, slots=True)
class GeomPair:
    """Two geoms that may touch."""

    geoms: tuple[int, int]
    number: int | None = None
    """The number of the `<pair>` that has the contact's parameters; None if the geoms have them."""


def geom_pairs(model: Any) -> Iterator[GeomPair]:
    """Yields the pairs of the file, then the other geoms that their bits and bodies let touch, by MuJoCo's
    filter."""
    own_pairs = list(zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True))
    yield from (GeomPair(geoms, number) for number, geoms in enumerate(own_pairs))
    listed = {frozenset(geoms) for geoms in own_pairs}
    excluded = set(model.exclude_signature.tolist())
    types, affinities = model.geom_contype.tolist(), model.geom_conaffinity.tolist()
    solid: dict[int, list[int]] = {}
    for geom, body in enumerate(model.geom_bodyid.tolist()):
        if types[geom] or affinities[geom]:
            solid.setdefault(body, []).append(geom)
    # A signature has the lower number first.
    for (low, firsts), (high, seconds) in combinations(sorted(solid.items()), 2):
        if (low << 16) + high in excluded or never_collide(model, low, high):
            continue
        for first, second in product(firsts, seconds):
            meets = types[first] & affinities[second] or types[second] & affinities[first]
            if meets and frozenset((first, second)) not in listed:
                yield GeomPair((first, second))
