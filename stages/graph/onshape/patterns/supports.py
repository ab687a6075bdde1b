"""Finds what supports the seeds of a pattern, and so their copies, and what the seeds carry themselves.

A copy of a wheel is mounted on the same axle as its seed, but the cap on the seed is not mounted on the
copy as well. Without the seeds the assembly falls into pieces, and one of them is the support: the piece
with the assembly's origin or with a fixed instance, else the piece with the most parts. Whether a seed
itself is fixed does not matter: its copies are not.

A pattern repeats the mates of its own assembly. Where none of these holds the seed, the mates of the
assembly around it place the seed, so they place its copies too.
"""

from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass

import networkx as nx

from linkwright.stages.graph.onshape.assembly import Assembly, Path


@dataclass(frozen=True, slots=True)
class Feature:
    """A mate or a mate group: the occurrences that it connects, and whether rigidly (as one body)."""

    title: str
    places: tuple[Path, ...]
    rigid: bool


@dataclass(frozen=True, slots=True)
class Support:
    """The support of the seeds of a pattern.

    `level`: the assembly whose mates and groups support them; `dependents`: instances of it that only
    the seeds support; `fastened`: occurrences in the seeds that are one body with the support (their
    other mates then only carry something); `within`, `above`: a feature that holds a seed in the
    pattern's own assembly, and one in an assembly around it, where either could place the copies; else
    empty.
    """

    level: Path
    dependents: frozenset[Path] = frozenset()
    fastened: frozenset[Path] = frozenset()
    within: str = ""
    above: str = ""


class SupportSearch:
    """Finds supports from the mates, groups and fixed instances of each assembly."""

    def __init__(self, assembly: Assembly) -> None:
        self.features: dict[Path, list[Feature]] = {}
        self.touching: dict[tuple[Path, Path], list[Feature]] = {}
        for mate in assembly.mates:
            places = tuple(entity.path for entity in mate.entities)
            self._take(mate.ref.owner, Feature(mate.title, places, mate.ref.type == "FASTENED"))
        for group in assembly.groups:
            self._take(group.owner, Feature(group.title, tuple(group.members), True))
        self.fixed: dict[Path, list[Path]] = {}
        for path in (path for path, occurrence in assembly.occurrences.items() if occurrence.fixed):
            for depth in range(len(path)):
                self.fixed.setdefault(path[:depth], []).append(path)
        self.parts = Counter(
            part.path[:depth] for part in assembly.parts for depth in range(1, len(part.path) + 1)
        )

    def _take(self, owner: Path, feature: Feature) -> None:
        self.features.setdefault(owner, []).append(feature)
        below = {place[:depth] for place in feature.places for depth in range(len(owner) + 1, len(place) + 1)}
        for place in sorted(below):
            self.touching.setdefault((owner, place), []).append(feature)

    def support(self, seeds: Collection[Path], owner: Path, rigid: Collection[Path]) -> Support:
        """The support of `seeds`, instances of `owner`, by its own features, else by those of the nearest
        assembly around it that has some. `rigid`: assemblies without inner motion, copies included."""
        levels = [owner] if owner in rigid else [owner[:depth] for depth in range(len(owner), -1, -1)]
        holding = {level: tuple(self._from_outside(seeds, level)) for level in levels}
        level = next((level for level in levels if holding[level]), owner)
        dependents = self._dependents(frozenset(seeds), owner, level)
        fastened = self._fastened(seeds, owner, level, dependents, holding[level], rigid)
        rigidly = any(feature.rigid for feature in holding[owner])
        outer = [feature for around in levels[1:] for feature in holding[around]]
        if level != owner or rigidly or not holding[owner] or not outer:
            return Support(level, dependents, fastened)
        return Support(level, dependents, fastened, holding[owner][0].title, outer[0].title)

    def _from_outside(self, seeds: Collection[Path], level: Path) -> Iterator[Feature]:
        """The features of `level` between a seed and an occurrence outside all seeds."""
        for seed in sorted(seeds):
            for feature in self.touching.get((level, seed), ()):
                if _outside(feature.places, seeds):
                    yield feature

    def _fastened(
        self,
        seeds: Collection[Path],
        owner: Path,
        level: Path,
        dependents: Collection[Path],
        holding: Collection[Feature],
        rigid: Collection[Path],
    ) -> frozenset[Path]:
        """The occurrences in seeds that features of `level` make one body with the support; empty where
        the seeds have no other mates."""
        fast = [
            feature
            for feature in holding
            if feature.rigid and _nodes(feature, owner, seeds) - set(dependents)
        ]
        if not fast or all(feature.rigid for feature in holding):
            return frozenset()

        def within(feature: Feature) -> dict[Path, Path]:
            """Each occurrence in a seed → the rigid sub-assembly around it, or itself."""
            return {
                place: next((place[:depth] for depth in range(len(place)) if place[:depth] in rigid), place)
                for place in feature.places
                if _inside(place, seeds)
            }

        bodies = nx.utils.UnionFind()
        for inner in (one for one in self.features if one in (owner, level) or _inside(one, seeds)):
            for feature in self.features[inner]:
                if feature.rigid:
                    bodies.union(*within(feature).values())
        supported = {bodies[node] for feature in fast for node in within(feature).values()}
        nodes = {place: node for feature in holding for place, node in within(feature).items()}
        return frozenset(place for place, node in nodes.items() if bodies[node] in supported)

    def holds(self, copy: Path, owner: Path, level: Path, others: Collection[Path]) -> bool:
        """Whether features of `level` support `copy`, an instance of `owner`, rather than only carry
        something on it: whether what they join to it reaches the origin or one of `others` (seeds, copies)
        without it."""
        pieces = self._pieces(frozenset([copy]), owner, level)
        ends = {pieces[level], *(pieces[one] for one in others if one != copy)}
        return any(
            pieces[node] in ends
            for feature in self.touching[level, copy]
            for node in _nodes(feature, owner, [copy])
        )

    def _dependents(self, seeds: frozenset[Path], owner: Path, level: Path) -> frozenset[Path]:
        """The instances that features of `level` join to `seeds`, instances of `owner`, and that only the
        seeds support; empty where two pieces of the same size could be the support. Instances as in
        `node_of`."""
        beside = {
            node
            for seed in seeds
            for feature in self.touching.get((level, seed), ())
            for node in _nodes(feature, owner, seeds)
        }
        if len(beside) < 2:
            return frozenset()
        pieces = self._pieces(seeds, owner, level)
        holder = pieces[level]
        if all(pieces[node] != holder for node in beside):
            sizes = Counter({pieces[node]: 0 for node in beside})
            for node in list(pieces):
                if pieces[node] in sizes:
                    sizes[pieces[node]] += self.parts[node]
            (holder, most), *others = sizes.most_common(2)
            if others and others[0][1] == most:
                return frozenset()
        return frozenset(node for node in beside if pieces[node] != holder)

    def _pieces(self, taken: frozenset[Path], owner: Path, level: Path) -> nx.utils.UnionFind:
        """The pieces that the assemblies from `level` down to `owner` form without `taken`; fixed instances
        belong to the piece of the origin of `level`."""
        pieces = nx.utils.UnionFind([level])
        for depth in range(len(level), len(owner) + 1):
            for feature in self.features.get(owner[:depth], ()):
                pieces.union(*_nodes(feature, owner, taken))
        for path in self.fixed.get(level, ()):
            if not _inside(path, taken):
                pieces.union(level, node_of(path, owner))
        return pieces


def node_of(place: Path, owner: Path) -> Path:
    """The instance that contains an occurrence: of `owner`, else of the innermost assembly around both."""
    common = 0
    while common < min(len(place), len(owner)) and place[common] == owner[common]:
        common += 1
    return place[: common + 1]


def _nodes(feature: Feature, owner: Path, taken: Collection[Path]) -> set[Path]:
    return {node_of(place, owner) for place in _outside(feature.places, taken)}


def _outside(places: Collection[Path], seeds: Collection[Path]) -> list[Path]:
    return [place for place in places if not _inside(place, seeds)]


def _inside(place: Path, seeds: Collection[Path]) -> bool:
    return any(place[: len(seed)] == seed for seed in seeds)
