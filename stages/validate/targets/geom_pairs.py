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
    """Yields the pairs that the file lists, then the other pairs of geoms that may touch by their bits and
    bodies: MuJoCo's filter."""
    listed_pairs = list(zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True))
    yield from (GeomPair(geoms, number) for number, geoms in enumerate(listed_pairs))
    listed_geoms = {frozenset(geoms) for geoms in listed_pairs}
    excluded_signatures = set(model.exclude_signature.tolist())
    types, affinities = model.geom_contype.tolist(), model.geom_conaffinity.tolist()
    geoms_by_body: dict[int, list[int]] = {}
    for geom, body in enumerate(model.geom_bodyid.tolist()):
        if types[geom] or affinities[geom]:
            geoms_by_body.setdefault(body, []).append(geom)
    for (low, low_geoms), (high, high_geoms) in combinations(sorted(geoms_by_body.items()), 2):
        # MuJoCo's signature of two bodies has the lower number in its upper 16 bits.
        if (low << 16) + high in excluded_signatures or never_collide(model, low, high):
            continue
        for first, second in product(low_geoms, high_geoms):
            may_touch = types[first] & affinities[second] or types[second] & affinities[first]
            if may_touch and frozenset((first, second)) not in listed_geoms:
                yield GeomPair((first, second))
