"""Patterned and mirrored instances: the mates and groups of their seeds, once more for each copy.

Onshape gives copies no mates of their own. With S the motion or reflection that takes a seed to its
copy at the saved pose, a mate of the seed becomes one of the copy: what it holds on the seed it holds
on the copy, at the same place, and what it holds elsewhere stays where it is, with its frame moved by S.
A mate by which something hangs on the seed is not repeated (`hanging`).
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import networkx as nx

from stages.graph.notes import Notes
from stages.graph.onshape.assembly import Assembly, Entity, Mate, MateGroup, Occurrence, Path, Pattern
from stages.graph.onshape.hanging import Hanging
from stages.robot.model import Array, frozen
from stages.robot.poses import inverse


@dataclass(slots=True)
class _Series:
    """A pattern at work. `gone`: copies that are not there or not like their seed; `free`: those
    without mates and groups of their own, which get their seed's; `hanging`: instances that hang on a
    seed, which a copy does not hold; `served`: those that got joints."""

    pattern: Pattern
    free: frozenset[Path]
    gone: frozenset[Path]
    hanging: frozenset[Path]
    joints: int = 0
    served: set[Path] = field(default_factory=set)


@dataclass(frozen=True, slots=True)
class _Image:
    """A feature on the `number`-th copies: its places there, the first seed and its copy. `fresh`: all
    copies that it acts for; `inside`: whether each of its places is on a copy."""

    series: _Series
    number: int
    seed: Path
    copy: Path
    places: tuple[Path, ...]
    fresh: frozenset[Path]
    inside: bool


def with_copies(assembly: Assembly, mirror: str, notes: Notes) -> Assembly:
    """The assembly with the mates and groups of all copies; a copied feature's `ref.copy` tells it.

    `mirror`: "joints", or "weld" for copies that are fastened where the first of their seeds' mates would
    hold them, and rigid inside. A copy that has mates of its own gets nothing; no relation is copied.
    """
    copier = _Copier(assembly, notes)
    if not copier.by_seed:
        return assembly
    drawn = [copy for mate in assembly.mates for copy in copier.mates(mate)]
    grouped = [copy for group in assembly.groups for copy in copier.groups(group)]
    mates, groups = [mate for mate, _ in drawn], [group for group, _ in grouped]
    stiff = assembly.stiff
    if mirror == "weld":
        mates = [copier.welded(mate) for mate in _holding(drawn, [image for _, image in grouped])]
        free = {path for one in copier.series for path in one.free}
        stiff |= {path for path in free if not assembly.occurrences[path].is_part}
    else:
        copier.tell_relations()
    copier.tell(weld=mirror == "weld")
    return replace(assembly, mates=[*assembly.mates, *mates], groups=[*assembly.groups, *groups], stiff=stiff)


class _Copier:
    def __init__(self, assembly: Assembly, notes: Notes) -> None:
        self.assembly, self.notes = assembly, notes
        self.series: list[_Series] = []
        self.by_seed: dict[Path, list[_Series]] = {}
        self.repeated: set[tuple[Path, str]] = set()
        mated, hanging = _mated(assembly), Hanging(assembly)
        for pattern in assembly.patterns:
            self._take_on(pattern, mated, hanging)

    def _take_on(self, pattern: Pattern, mated: Mapping[Path, set[Path]], hanging: Hanging) -> None:
        """Files a pattern under its seeds, and tells what of it cannot be copied."""
        occurrences, own = self.assembly.occurrences, mated.get(pattern.owner, set())
        free, gone, seeds = set(), set(), []
        for seed, copies in pattern.copies.items():
            alive = [copy for copy in copies if copy in occurrences]
            gone.update(set(copies) - set(alive))
            if seed not in occurrences:
                if not alive:
                    continue
                titles = ", ".join(occurrences[copy].title for copy in alive)
                message = f"the seed of {titles} is suppressed or gone: it has no joints to copy"
                self.notes.tell("W-PATTERN", message, pattern.title, "mate the copies themselves")
                continue
            seeds.append(seed)
            for copy in alive:
                if copy in own:
                    continue
                if _source(occurrences[copy]) == _source(occurrences[seed]):
                    free.add(copy)
                    continue
                gone.add(copy)
                message = (
                    f"{occurrences[copy].title} is made of another part than its seed: "
                    "where the seed's mates would hold it is not known"
                )
                self.notes.tell("W-PATTERN", message, pattern.title, "mate it itself")
        hung = hanging.on(seeds, pattern.owner) if free else frozenset()
        series = _Series(pattern, frozenset(free), frozenset(gone), hung)
        self.series.append(series)
        for seed in seeds:
            self.by_seed.setdefault(seed, []).append(series)

    def mates(self, mate: Mate) -> Iterator[tuple[Mate, _Image]]:
        """The copies of a mate, those of its copies included; one for each copied instance, however
        often that is listed."""
        waiting: list[tuple[Mate, frozenset[Path] | None]] = [(mate, None)]
        made: set[Path] = set()
        for drawn, fresh in waiting:
            for image in self._images(mate.ref.owner, [e.path for e in drawn.entities], fresh, mate.title):
                if image.copy in made:
                    continue
                made.add(image.copy)
                if mate.ref.type != "FASTENED":
                    image.series.joints += 1
                    image.series.served |= image.fresh
                    self.repeated.add((mate.ref.owner, mate.ref.feature))
                copy = self._mate(mate.ref.name, drawn, image)
                waiting.append((copy, image.fresh))
                yield copy, image

    def groups(self, group: MateGroup) -> Iterator[tuple[MateGroup, _Image]]:
        """The copies of a mate group, those of its copies included."""
        waiting: list[tuple[MateGroup, frozenset[Path] | None]] = [(group, None)]
        made: set[Path] = set()
        for drawn, fresh in waiting:
            for image in self._images(group.owner, drawn.members, fresh, group.title):
                if image.copy not in made:
                    made.add(image.copy)
                    copy = MateGroup(group.owner, group.title, image.places)
                    waiting.append((copy, image.fresh))
                    yield copy, image

    def _images(
        self, owner: Path, places: Sequence[Path], fresh: frozenset[Path] | None, title: str
    ) -> Iterator[_Image]:
        """Where a feature acts again, once for each copy of each pattern whose seeds it touches.

        `fresh`: of a feature that is a copy itself, the instances that it was moved to; only these
        lead on to further copies.
        """
        touched: dict[int, tuple[_Series, dict[int, Path]]] = {}
        for index, place in enumerate(places):
            for depth in range(len(owner) + 1, len(place) + 1):
                seed = place[:depth]
                if fresh is None or seed in fresh:
                    for series in self.by_seed.get(seed, ()):
                        if series.pattern.owner == owner:
                            touched.setdefault(id(series), (series, {}))[1].setdefault(index, seed)
        for series, seeds in touched.values():
            for number in range(max(len(series.pattern.copies[seed]) for seed in seeds.values())):
                image = self._image(series, number, places, seeds, title)
                if image is not None:
                    yield image

    def _image(
        self, series: _Series, number: int, places: Sequence[Path], seeds: Mapping[int, Path], title: str
    ) -> _Image | None:
        """None where a copy is not there, where all copies have mates of their own, or where a place
        that is no seed's hangs on one."""
        copies = {
            index: (seed, series.pattern.copies[seed][number])
            for index, seed in seeds.items()
            if number < len(series.pattern.copies[seed])
        }
        beside = {
            place[: len(series.pattern.owner) + 1] for at, place in enumerate(places) if at not in seeds
        }
        if beside & series.hanging:
            return None
        movers = [pair for pair in copies.values() if pair[1] in series.free]
        if not movers or any(copy in series.gone for _, copy in copies.values()):
            return None
        moved = list(places)
        for index, (seed, copy) in copies.items():
            moved[index] = copy + places[index][len(seed) :]
            if moved[index] not in self.assembly.occurrences:
                message = f"{self.assembly.occurrences[copy].title} lacks what this holds on its seed"
                self.notes.tell("W-PATTERN", message, title, "mate the copy itself")
                return None
        fresh = frozenset(copy for _, copy in movers)
        inside = len(copies) == len(places)
        return _Image(series, number, *movers[0], tuple(moved), fresh, inside)

    def _mate(self, name: str, drawn: Mate, image: _Image) -> Mate:
        assembly = self.assembly
        copy_from_seed = assembly.world_from_path(image.copy) @ inverse(assembly.world_from_path(image.seed))
        entities = tuple(
            replace(entity, path=place)
            if place != entity.path
            else Entity(place, self._moved(entity, copy_from_seed))
            for entity, place in zip(drawn.entities, image.places, strict=True)
        )
        owner, copied = drawn.ref.owner, assembly.occurrences[image.copy]
        found = re.search(r"<(\d+)>\s*$", copied.names[-1])
        name = f"{name} <{found[1] if found else image.number + 2}>"
        names = assembly.occurrences[owner].names if owner else ()
        ref = replace(drawn.ref, name=name, copy=image.copy[-1])
        return Mate(ref, "/".join((*names, name)), entities, drawn.limits)

    def _moved(self, entity: Entity, motion: Array) -> Array:
        """The entity's frame on its own occurrence once `motion` (4, 4) of the world has moved it."""
        occurrence_from_world = inverse(self.assembly.world_from_path(entity.path))
        return frozen(occurrence_from_world @ motion @ self.assembly.world_from(entity))

    def welded(self, mate: Mate) -> Mate:
        """FASTENED instead, where its sides are at the saved pose."""
        first, second = mate.entities
        second_from_world = inverse(self.assembly.world_from_path(second.path))
        held = Entity(second.path, frozen(second_from_world @ self.assembly.world_from(first)))
        return replace(mate, ref=replace(mate.ref, type="FASTENED"), entities=(first, held), limits={})

    def tell_relations(self) -> None:
        """Names the relations of mates that act again, or lie in a copied sub-assembly."""
        for relation in self.assembly.relations:
            below = [
                path[:depth]
                for path, _ in relation.mates
                for depth in range(len(relation.owner) + 1, len(path) + 1)
            ]
            inside = any(
                series.free and series.pattern.owner == relation.owner
                for path in below
                for series in self.by_seed.get(path, ())
            )
            if inside or any(mate in self.repeated for mate in relation.mates):
                message = "it relates joints that a pattern or mirror repeats: the copies' are not related"
                self.notes.tell("W-PATTERN-RELATION", message, relation.title, "mate and relate the copies")

    def tell(self, weld: bool) -> None:
        """One finding for each pattern that has copied joints."""
        for series in self.series:
            count, copies = series.joints, len(series.served)
            if not count:
                continue
            message = (
                f"{copies} instance(s) welded in the place of {count} joint(s) (mirror: weld)"
                if weld
                else f"{count} joint(s) copied for {copies} instance(s): independent of those of the seed"
            )
            self.notes.tell("I-PATTERN", message, series.pattern.title)


def _holding(mates: Iterable[tuple[Mate, _Image]], groups: Iterable[_Image]) -> list[Mate]:
    """The copied mates that take part when copies are welded.

    Copies that hang together are welded to the rest by one mate: by more, they would freeze what lies
    between these. What is FASTENED stays so.
    """
    rest: Path = ()
    held = nx.utils.UnionFind([rest])
    for image in groups:
        held.union(*image.fresh, *(() if image.inside else (rest,)))

    def late(copy: tuple[Mate, _Image]) -> tuple[object, ...]:
        mate, image = copy
        return mate.ref.type != "FASTENED", not image.inside, mate.title, mate.key

    found = []
    for mate, image in sorted(mates, key=late):
        if mate.ref.type == "FASTENED" or image.inside or held[image.copy] != held[rest]:
            held.union(*image.fresh, *(() if image.inside else (rest,)))
            found.append(mate)
    return found


def _mated(assembly: Assembly) -> dict[Path, set[Path]]:
    """Owner → the instances, and all in them, that a mate or group of its names."""
    held = [(mate.ref.owner, entity.path) for mate in assembly.mates for entity in mate.entities]
    held += [(group.owner, member) for group in assembly.groups for member in group.members]
    found: dict[Path, set[Path]] = {}
    for owner, path in held:
        for depth in range(len(owner) + 1, len(path) + 1):
            found.setdefault(owner, set()).add(path[:depth])
    return found


def _source(occurrence: Occurrence) -> tuple[object, ...]:
    return tuple(occurrence.record.get(key) for key in ("type", "documentId", "elementId", "partId"))
