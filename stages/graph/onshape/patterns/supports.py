"""Finds the support and the dependents of a pattern's seeds.

A seed is an instance that the pattern copies. The support is what the seeds, and so their copies, are mounted
on. Dependents are instances that only the seeds hold. Each copy of a wheel, for example, is mounted on the
axle of its seed, the support; the hub cap on the seed, a dependent, is not mounted on the copies.

If the seeds are taken out, the assembly falls into pieces. The support is the piece that contains the
assembly's origin or a fixed instance, else the piece with the most parts. A seed that is fixed itself still
needs a support, since its copies are not fixed.

A pattern repeats the mates of its own assembly. If none of these holds the seed, the mates of an enclosing
assembly place the seed, so they place its copies too.
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
    occurrences: tuple[Path, ...]
    """The occurrences that it connects."""
    rigid: bool
    """Whether they cannot move relative to each other."""


@dataclass(frozen=True, slots=True)
class Support:
    """The support of the seeds of a pattern."""

    assembly: Path
    """The assembly whose mates and mate groups support the seeds."""
    dependents: frozenset[Path] = frozenset()
    """Instances of that assembly that only the seeds support."""
    fastened: frozenset[Path] = frozenset()
    """Occurrences in the seeds that are rigidly joined to the support. Their other mates do not support them,
    but carry other instances."""
    inner_title: str = ""
    """Title of a feature of the pattern's own assembly that holds a seed, if an enclosing assembly has such a
    feature too; else ""."""
    outer_title: str = ""
    """Title of the enclosing assembly's feature; else ""."""


class SupportSearch:
    """Finds supports from the mates, groups and fixed instances of each assembly."""

    features: dict[Path, list[Feature]]
    """Assembly → its features."""

    features_by_instance: dict[tuple[Path, Path], list[Feature]]
    """(assembly, instance in it) → the features of the assembly that connect an occurrence in the
    instance."""

    fixed_instances: dict[Path, list[Path]]
    """Assembly → the fixed instances in it."""

    part_counts: Counter[Path]
    """Instance → the number of parts in it."""

    def __init__(self, assembly: Assembly) -> None:
        self.features, self.features_by_instance, self.fixed_instances = {}, {}, {}
        for mate in assembly.mates:
            occurrences = tuple(entity.path for entity in mate.entities)
            self._add_feature(mate.ref.owner, Feature(mate.title, occurrences, mate.ref.type == "FASTENED"))
        for group in assembly.groups:
            self._add_feature(group.owner, Feature(group.title, tuple(group.members), True))
        for path in (path for path, occurrence in assembly.occurrences.items() if occurrence.fixed):
            for depth in range(len(path)):
                self.fixed_instances.setdefault(path[:depth], []).append(path)
        self.part_counts = Counter(
            part.path[:depth] for part in assembly.parts for depth in range(1, len(part.path) + 1)
        )

    def _add_feature(self, owner: Path, feature: Feature) -> None:
        self.features.setdefault(owner, []).append(feature)
        paths_below = {
            occurrence[:depth]
            for occurrence in feature.occurrences
            for depth in range(len(owner) + 1, len(occurrence) + 1)
        }
        for path in sorted(paths_below):
            self.features_by_instance.setdefault((owner, path), []).append(feature)

    def support(self, seeds: Collection[Path], owner: Path, rigid_assemblies: Collection[Path]) -> Support:
        """Returns the support of `seeds`, which are instances of `owner`.

        The features of `owner` decide. If none of them holds a seed, the features of the nearest enclosing
        assembly with such a feature decide. `rigid_assemblies`: assemblies without inner motion, including
        copies.
        """
        return _SeedSearch(self, frozenset(seeds), owner, rigid_assemblies).support()

    def is_supported(self, copy: Path, owner: Path, level: Path, members: Collection[Path]) -> bool:
        """Tells whether features of `level` support `copy`, an instance of `owner`.

        They do if they join it to a piece that contains the origin, or another of the `members` (seeds and
        copies). All other instances that they join to it are carried by it.
        """
        pieces = self.pieces(frozenset([copy]), owner, level)
        # `pieces[level]` is the piece that contains the origin.
        supporting_pieces = {pieces[level], *(pieces[member] for member in members if member != copy)}
        return any(
            pieces[node] in supporting_pieces
            for feature in self.features_by_instance[level, copy]
            for node in _nodes(feature, owner, [copy])
        )

    def pieces(self, excluded: frozenset[Path], owner: Path, level: Path) -> nx.utils.UnionFind:
        """Returns the pieces into which the assemblies from `level` down to `owner` fall if the instances
        `excluded` are taken out. Fixed instances belong to the piece of the origin of `level`."""
        pieces = nx.utils.UnionFind([level])
        for depth in range(len(level), len(owner) + 1):
            for feature in self.features.get(owner[:depth], ()):
                pieces.union(*_nodes(feature, owner, excluded))
        for path in self.fixed_instances.get(level, ()):
            if not _inside(path, excluded):
                pieces.union(level, node_of(path, owner))
        return pieces


@dataclass(frozen=True, slots=True)
class _SeedSearch:
    """Finds the support of the seeds of a pattern."""

    search: SupportSearch
    seeds: frozenset[Path]
    owner: Path
    """The assembly of the pattern, whose instances the seeds are."""
    rigid_assemblies: Collection[Path]
    """Assemblies without inner motion."""

    def support(self) -> Support:
        """Returns the support (see `SupportSearch.support`)."""
        owner = self.owner
        levels = (
            [owner]
            if owner in self.rigid_assemblies
            else [owner[:depth] for depth in range(len(owner), -1, -1)]
        )
        features_by_level = {level: tuple(self._holding_features(level)) for level in levels}
        level = next((level for level in levels if features_by_level[level]), owner)
        dependents = self._dependents(level)
        fastened = self._fastened(level, dependents, features_by_level[level])
        inner_features = features_by_level[owner]
        outer_features = [feature for outer in levels[1:] for feature in features_by_level[outer]]
        is_fastened = any(feature.rigid for feature in inner_features)
        # Titles are returned only if there was a choice: a movable feature holds a seed, and one outside
        # could too.
        if is_fastened or not inner_features or not outer_features:
            return Support(level, dependents, fastened)
        return Support(level, dependents, fastened, inner_features[0].title, outer_features[0].title)

    def _holding_features(self, level: Path) -> Iterator[Feature]:
        """Yields the features of `level` between a seed and an occurrence outside all seeds."""
        for seed in sorted(self.seeds):
            for feature in self.search.features_by_instance.get((level, seed), ()):
                if _outside(feature.occurrences, self.seeds):
                    yield feature

    def _fastened(
        self, level: Path, dependents: frozenset[Path], holding: Collection[Feature]
    ) -> frozenset[Path]:
        """Returns the occurrences in the seeds that rigid features of `holding` join to the support; empty if
        all of `holding` are rigid, since there are then no other mates to tell apart."""
        rigid_features = [
            feature
            for feature in holding
            if feature.rigid and _nodes(feature, self.owner, self.seeds) - dependents
        ]
        if not rigid_features or all(feature.rigid for feature in holding):
            return frozenset()
        rigid_groups = self._rigid_groups(level)
        supported_groups = {
            rigid_groups[body]
            for feature in rigid_features
            for body in self._bodies_in_seeds(feature).values()
        }
        return frozenset(
            occurrence
            for feature in holding
            for occurrence, body in self._bodies_in_seeds(feature).items()
            if rigid_groups[body] in supported_groups
        )

    def _rigid_groups(self, level: Path) -> nx.utils.UnionFind:
        """Returns the groups of bodies in the seeds (see `_bodies_in_seeds`) that rigid features join."""
        groups = nx.utils.UnionFind()
        for assembly, features in self.search.features.items():
            if assembly in (self.owner, level) or _inside(assembly, self.seeds):
                for feature in features:
                    if feature.rigid:
                        groups.union(*self._bodies_in_seeds(feature).values())
        return groups

    def _bodies_in_seeds(self, feature: Feature) -> dict[Path, Path]:
        """Maps each occurrence in a seed to the rigid assembly around it, or to itself."""
        return {
            occurrence: next(
                (
                    occurrence[:depth]
                    for depth in range(len(occurrence))
                    if occurrence[:depth] in self.rigid_assemblies
                ),
                occurrence,
            )
            for occurrence in feature.occurrences
            if _inside(occurrence, self.seeds)
        }

    def _dependents(self, level: Path) -> frozenset[Path]:
        """Returns the instances (see `node_of`) that features of `level` join to the seeds and that nothing
        else supports; empty if the support is ambiguous, since two pieces have the most parts."""
        neighbours = {
            node
            for seed in self.seeds
            for feature in self.search.features_by_instance.get((level, seed), ())
            for node in _nodes(feature, self.owner, self.seeds)
        }
        if len(neighbours) < 2:
            return frozenset()
        pieces = self.search.pieces(self.seeds, self.owner, level)
        support_piece = self._support_piece(pieces, neighbours, level)
        if support_piece is None:
            return frozenset()
        return frozenset(node for node in neighbours if pieces[node] != support_piece)

    def _support_piece(
        self, pieces: nx.utils.UnionFind, neighbours: Collection[Path], level: Path
    ) -> Path | None:
        """Returns the piece that is the support: the piece that contains the origin if a neighbour is in it,
        else the piece with the most parts; None if two pieces have the most parts."""
        origin_piece: Path = pieces[level]
        if any(pieces[node] == origin_piece for node in neighbours):
            return origin_piece
        sizes = Counter({pieces[node]: 0 for node in neighbours})
        for node in list(pieces):
            if pieces[node] in sizes:
                sizes[pieces[node]] += self.search.part_counts[node]
        (largest, size), *runners_up = sizes.most_common(2)
        return None if runners_up and runners_up[0][1] == size else largest


def node_of(occurrence: Path, owner: Path) -> Path:
    """Returns the instance that contains an occurrence: an instance of `owner` if the occurrence is inside
    it, else an instance of the innermost assembly that contains both."""
    common = 0
    while common < min(len(occurrence), len(owner)) and occurrence[common] == owner[common]:
        common += 1
    return occurrence[: common + 1]


def _nodes(feature: Feature, owner: Path, excluded: Collection[Path]) -> set[Path]:
    """Returns the instances (see `node_of`) that a feature connects, without those in `excluded`."""
    return {node_of(occurrence, owner) for occurrence in _outside(feature.occurrences, excluded)}


def _outside(occurrences: Collection[Path], seeds: Collection[Path]) -> list[Path]:
    """Returns the occurrences that are in none of the seeds."""
    return [occurrence for occurrence in occurrences if not _inside(occurrence, seeds)]


def _inside(occurrence: Path, seeds: Collection[Path]) -> bool:
    """Tells whether an occurrence is a seed or in a seed."""
    return any(occurrence[: len(seed)] == seed for seed in seeds)
