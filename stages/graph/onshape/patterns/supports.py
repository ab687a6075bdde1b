"""Finds the supports of a pattern's seeds, and so of their copies, and the instances that the seeds carry.

A copy of a wheel is mounted on the same axle as its seed, but the cap on the seed is not mounted on the copy
as well. Without the seeds the assembly falls into pieces. The support is the piece with the assembly's origin
or with a fixed instance, else the piece with the most parts. Whether a seed itself is fixed does not matter:
its copies are not.

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
    """A mate or a mate group."""

    title: str
    places: tuple[Path, ...]
    """The occurrences that it connects."""
    rigid: bool
    """Whether it connects them to one body."""


@dataclass(frozen=True, slots=True)
class Support:
    """The support of the seeds of a pattern."""

    level: Path
    """The assembly whose mates and groups support them."""
    dependents: frozenset[Path] = frozenset()
    """Instances of that assembly that only the seeds support."""
    fastened: frozenset[Path] = frozenset()
    """Occurrences in the seeds that are one body with the support: their other mates then only carry
    something."""
    within: str = ""
    """A feature that holds a seed in the pattern's own assembly, if `above` could place the copies as well;
    else empty."""
    above: str = ""
    """A feature that holds a seed in an assembly around it, if `within` could place the copies as well; else
    empty."""


class SupportSearch:
    """Finds supports from the mates, groups and fixed instances of each assembly."""

    def __init__(self, assembly: Assembly) -> None:
        self.features: dict[Path, list[Feature]] = {}
        self.touching: dict[tuple[Path, Path], list[Feature]] = {}
        for mate in assembly.mates:
            places = tuple(entity.path for entity in mate.entities)
            self._add_feature(mate.ref.owner, Feature(mate.title, places, mate.ref.type == "FASTENED"))
        for group in assembly.groups:
            self._add_feature(group.owner, Feature(group.title, tuple(group.members), True))
        self.fixed: dict[Path, list[Path]] = {}
        for path in (path for path, occurrence in assembly.occurrences.items() if occurrence.fixed):
            for depth in range(len(path)):
                self.fixed.setdefault(path[:depth], []).append(path)
        self.parts = Counter(
            part.path[:depth] for part in assembly.parts for depth in range(1, len(part.path) + 1)
        )

    def _add_feature(self, owner: Path, feature: Feature) -> None:
        self.features.setdefault(owner, []).append(feature)
        paths_below = {
            place[:depth] for place in feature.places for depth in range(len(owner) + 1, len(place) + 1)
        }
        for place in sorted(paths_below):
            self.touching.setdefault((owner, place), []).append(feature)

    def support(self, seeds: Collection[Path], owner: Path, rigid: Collection[Path]) -> Support:
        """Returns the support of `seeds`, instances of `owner`, by its own features, else by those of the
        nearest assembly around it that has some. `rigid`: assemblies without inner motion, copies
        included."""
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
        """Yields the features of `level` between a seed and an occurrence outside all seeds."""
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
        """Returns the occurrences in seeds that features of `level` join to the body of the support; empty
        where the seeds have no other mates."""
        fast = [
            feature
            for feature in holding
            if feature.rigid and _nodes(feature, owner, seeds) - set(dependents)
        ]
        if not fast or all(feature.rigid for feature in holding):
            return frozenset()

        def within(feature: Feature) -> dict[Path, Path]:
            """Maps each occurrence in a seed to the rigid sub-assembly around it, or to itself."""
            return {
                place: next((place[:depth] for depth in range(len(place)) if place[:depth] in rigid), place)
                for place in feature.places
                if _inside(place, seeds)
            }

        bodies = nx.utils.UnionFind()
        for inner in (
            assembly for assembly in self.features if assembly in (owner, level) or _inside(assembly, seeds)
        ):
            for feature in self.features[inner]:
                if feature.rigid:
                    bodies.union(*within(feature).values())
        supported = {bodies[node] for feature in fast for node in within(feature).values()}
        nodes = {place: node for feature in holding for place, node in within(feature).items()}
        return frozenset(place for place, node in nodes.items() if bodies[node] in supported)

    def holds(self, copy: Path, owner: Path, level: Path, members: Collection[Path]) -> bool:
        """Returns whether features of `level` support `copy`, an instance of `owner`: whether they connect it
        to the origin or to another of the `members` (seeds, copies) without it. Otherwise they only connect
        it to something that it carries."""
        pieces = self._pieces(frozenset([copy]), owner, level)
        ends = {pieces[level], *(pieces[member] for member in members if member != copy)}
        return any(
            pieces[node] in ends
            for feature in self.touching[level, copy]
            for node in _nodes(feature, owner, [copy])
        )

    def _dependents(self, seeds: frozenset[Path], owner: Path, level: Path) -> frozenset[Path]:
        """Returns the instances (see `node_of`) that features of `level` join to `seeds`, and that only the
        seeds support; empty if two pieces of the same size could be the support."""
        neighbours = {
            node
            for seed in seeds
            for feature in self.touching.get((level, seed), ())
            for node in _nodes(feature, owner, seeds)
        }
        if len(neighbours) < 2:
            return frozenset()
        pieces = self._pieces(seeds, owner, level)
        holder = pieces[level]
        if all(pieces[node] != holder for node in neighbours):
            sizes = Counter({pieces[node]: 0 for node in neighbours})
            for node in list(pieces):
                if pieces[node] in sizes:
                    sizes[pieces[node]] += self.parts[node]
            (holder, size), *runners_up = sizes.most_common(2)
            if runners_up and runners_up[0][1] == size:
                return frozenset()
        return frozenset(node for node in neighbours if pieces[node] != holder)

    def _pieces(self, excluded: frozenset[Path], owner: Path, level: Path) -> nx.utils.UnionFind:
        """Returns the pieces that the assemblies from `level` down to `owner` form without the instances
        `excluded`. Fixed instances belong to the piece of the origin of `level`."""
        pieces = nx.utils.UnionFind([level])
        for depth in range(len(level), len(owner) + 1):
            for feature in self.features.get(owner[:depth], ()):
                pieces.union(*_nodes(feature, owner, excluded))
        for path in self.fixed.get(level, ()):
            if not _inside(path, excluded):
                pieces.union(level, node_of(path, owner))
        return pieces


def node_of(place: Path, owner: Path) -> Path:
    """Returns the instance that contains an occurrence: of `owner`, else of the innermost assembly around
    both."""
    common = 0
    while common < min(len(place), len(owner)) and place[common] == owner[common]:
        common += 1
    return place[: common + 1]


def _nodes(feature: Feature, owner: Path, excluded: Collection[Path]) -> set[Path]:
    return {node_of(place, owner) for place in _outside(feature.places, excluded)}


def _outside(places: Collection[Path], seeds: Collection[Path]) -> list[Path]:
    return [place for place in places if not _inside(place, seeds)]


def _inside(place: Path, seeds: Collection[Path]) -> bool:
    return any(place[: len(seed)] == seed for seed in seeds)
