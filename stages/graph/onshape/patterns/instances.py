"""Copies the mates and groups of patterned and mirrored instances to each of their copies.

Onshape gives copies no mates of their own. With S the motion or reflection that takes a seed to its
copy at the saved pose, a mate of the seed becomes a mate of the copy: on the side of the seed it joins
the copy at the same place, moved by S; its other side stays on its occurrence, with its frame moved by S.
A copy that is a sub-assembly of mirror-image parts has no mates inside: it gets those inside its seed.
A mate by which the seed carries something is not copied (see `carried`).
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import networkx as nx

from linkwright.stages.graph.onshape.assembly import Assembly, Entity, Mate, MateGroup, Path, Pattern
from linkwright.stages.graph.onshape.mass.part_solids import PartSolids
from linkwright.stages.graph.onshape.patterns.copies import CopySeries, copy_series_by_seed
from linkwright.stages.graph.onshape.patterns.mirror_planes import Image, MirrorPlanes
from linkwright.stages.graph.onshape.patterns.supports import Feature, node_of
from linkwright.stages.graph.onshape.rigid_subassemblies import rigid_subassemblies
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import frozen
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.robot.text.plural import count


@dataclass(frozen=True, slots=True)
class _Image:
    """A feature, moved to the `number`-th copies of a series."""

    series: CopySeries
    number: int
    copy: Path
    """The first copy for which the feature is made."""
    places: tuple[Path, ...]
    """Paths of the occurrences that the moved feature connects."""
    copies: tuple[Path, ...]
    """The copy that contains each place; () if no copy does."""
    target_copies: frozenset[Path]
    """All copies for which the feature is made."""

    @property
    def inside(self) -> bool:
        """Whether each place is on a copy."""
        return all(self.copies)


def with_copies(assembly: Assembly, keys: GraphSections, solids: PartSolids, log: Diagnostics) -> Assembly:
    """Returns the assembly with the mates and groups of all copies; a copied feature has a `ref.copy`.

    `keys.mirror`: "joints", or "weld" for copies that are fastened where the first of their seeds' mates
    would hold them, and rigid inside. A copy that has mates of its own gets nothing; no relation is copied.
    `keys.depth`: which sub-assemblies have no inner motion: their copies need no mates inside.

    The patterns of outer assemblies come first: their copied features support what is inside the copies.
    """
    planes = MirrorPlanes(assembly, solids, keys.mirrors, log)
    patterns = sorted(assembly.patterns, key=lambda pattern: len(pattern.owner))
    for _, same_depth_patterns in groupby(patterns, key=lambda pattern: len(pattern.owner)):
        assembly = _with_copies_of(list(same_depth_patterns), assembly, planes, keys, log)
    return assembly


def _with_copies_of(
    patterns: Sequence[Pattern],
    assembly: Assembly,
    planes: MirrorPlanes,
    keys: GraphSections,
    log: Diagnostics,
) -> Assembly:
    # Errors in the globs of `depth` are reported where the bodies are found.
    rigid = rigid_subassemblies(assembly, keys.depth, Diagnostics())
    mirror = keys.mirror
    copier = _Copier(assembly, copy_series_by_seed(assembly, patterns, rigid, planes, log), log)
    copied_mates = [copy for mate in assembly.mates for copy in copier.mates(mate)]
    copied_groups = [copy for group in assembly.groups for copy in copier.groups(group)]
    mates, groups = [mate for mate, _ in copied_mates], [group for group, _ in copied_groups]
    stiff = assembly.stiff
    if mirror == "weld":
        mates = [
            copier.welded(mate)
            for mate in _holding_mates(copied_mates, [image for _, image in copied_groups])
        ]
        free = {path for series in copier.series for path in series.unsupported_copies}
        stiff |= {path for path in free if not assembly.occurrences[path].is_part}
    else:
        copier.report_relations()
    copier.report_joints(weld=mirror == "weld")
    return replace(assembly, mates=[*assembly.mates, *mates], groups=[*assembly.groups, *groups], stiff=stiff)


class _Copier:
    def __init__(
        self, assembly: Assembly, by_seed: Mapping[Path, list[CopySeries]], log: Diagnostics
    ) -> None:
        self.assembly, self.log, self.by_seed = assembly, log, by_seed
        self.series = list(
            {id(series): series for series_list in by_seed.values() for series in series_list}.values()
        )
        self.repeated: set[tuple[Path, str]] = set()

    def mates(self, mate: Mate) -> Iterator[tuple[Mate, _Image]]:
        """Yields the copies of a mate, those of its copies included: a single mate for each copied instance,
        however often that is listed."""
        pending: list[tuple[Mate, frozenset[Path] | None]] = [(mate, None)]
        copied: set[Path] = set()
        owner, rigid = mate.ref.owner, mate.ref.type == "FASTENED"
        for source, target_copies in pending:
            feature = Feature(mate.title, tuple(e.path for e in source.entities), rigid)
            for image in self._images(owner, feature, target_copies):
                if image.copy in copied:
                    continue
                copied.add(image.copy)
                if not rigid:
                    image.series.joint_count += 1
                    image.series.copies_with_joints |= image.target_copies
                    self.repeated.add((mate.ref.owner, mate.ref.feature))
                copy = self._mate(mate.ref.name, source, image)
                pending.append((copy, image.target_copies))
                yield copy, image

    def groups(self, group: MateGroup) -> Iterator[tuple[MateGroup, _Image]]:
        """Yields the copies of a mate group, those of its copies included."""
        pending: list[tuple[MateGroup, frozenset[Path] | None]] = [(group, None)]
        copied: set[Path] = set()
        for source, target_copies in pending:
            feature = Feature(group.title, tuple(source.members), True)
            for image in self._images(group.owner, feature, target_copies):
                if image.copy not in copied:
                    copied.add(image.copy)
                    copy = MateGroup(group.owner, group.title, image.places)
                    pending.append((copy, image.target_copies))
                    yield copy, image

    def _images(
        self, owner: Path, feature: Feature, target_copies: frozenset[Path] | None
    ) -> Iterator[_Image]:
        """Yields the images of a feature: an image for each copy of each pattern whose seeds it touches.

        `target_copies`: of a feature that is a copy itself, the instances that it was moved to; only these
        lead on to further copies.
        """
        seeds_by_series: dict[int, tuple[CopySeries, dict[int, Path]]] = {}
        for index, place in enumerate(feature.occurrences):
            for depth in range(len(owner) + 1, len(place) + 1):
                seed = place[:depth]
                if target_copies is None or seed in target_copies:
                    for series in self.by_seed.get(seed, ()):
                        if series.repeats_features_of(owner):
                            seeds_by_series.setdefault(id(series), (series, {}))[1].setdefault(index, seed)
        for series, seeds in seeds_by_series.values():
            for number in range(max(len(series.pattern.copies[seed]) for seed in seeds.values())):
                image = self._image(series, number, feature, seeds)
                if image is not None:
                    yield image
        if target_copies is None:
            yield from self._inner_images(owner, feature)

    def _inner_images(self, owner: Path, feature: Feature) -> Iterator[_Image]:
        """Yields the images of a feature of a seed in its bare mirror copies."""
        for seed in (owner[:depth] for depth in range(1, len(owner) + 1)):
            for series in self.by_seed.get(seed, ()):
                for number, copy in enumerate(series.pattern.copies[seed]):
                    if copy in series.bare_mirror_copies:
                        copies = dict.fromkeys(range(len(feature.occurrences)), (seed, copy))
                        places = self._moved_places(series, feature, copies)
                        if places is not None:
                            inside = (copy,) * len(places)
                            yield _Image(series, number, copy, places, inside, frozenset([copy]))

    def _image(
        self, series: CopySeries, number: int, feature: Feature, seeds: Mapping[int, Path]
    ) -> _Image | None:
        """Returns the image of a feature on the `number`-th copies, or None: if a copy is missing, if all
        copies have mates of their own, if a seed carries a place that is not on a seed, or if a joint leads
        from a fastened seed to something else."""
        support, places = series.support, feature.occurrences
        copies = {
            index: (seed, series.pattern.copies[seed][number])
            for index, seed in seeds.items()
            if number < len(series.pattern.copies[seed])
        }
        partners = {
            node_of(place, series.pattern.owner)
            for place_index, place in enumerate(places)
            if place_index not in seeds
        }
        if partners & support.dependents:
            return None
        target_pairs = [pair for pair in copies.values() if pair[1] in series.unsupported_copies]
        if not target_pairs or any(copy not in series.images for _, copy in copies.values()):
            return None
        if partners and not feature.rigid and support.fastened.issuperset(places[index] for index in seeds):
            series.carrying_mate_titles.add(feature.title)
            return None
        moved_places = self._moved_places(series, feature, copies)
        if moved_places is None:
            return None
        on_copies = tuple(copies[index][1] if index in copies else () for index in range(len(places)))
        target_copies = frozenset(copy for _, copy in target_pairs)
        return _Image(series, number, target_pairs[0][1], moved_places, on_copies, target_copies)

    def _moved_places(
        self, series: CopySeries, feature: Feature, copies: Mapping[int, tuple[Path, Path]]
    ) -> tuple[Path, ...] | None:
        """Returns the places of a feature on copies, by index → (seed, copy); None if any has no
        counterpart."""
        moved = list(feature.occurrences)
        for index, (seed, copy) in copies.items():
            moved[index] = series.counterpart(seed, copy, moved[index])
            if moved[index] not in self.assembly.occurrences:
                message = (
                    f"{self.assembly.occurrences[copy].title} has no counterpart of what this mate holds"
                )
                self.log.report("W-PATTERN", message, feature.title, "mate the copy itself")
                return None
        return tuple(moved)

    def _mate(self, name: str, source: Mate, image: _Image) -> Mate:
        assembly = self.assembly
        entities = tuple(
            self._entity(entity, place, image.series.images[copy or image.copy], bool(copy))
            for entity, place, copy in zip(source.entities, image.places, image.copies, strict=True)
        )
        owner, copied = source.ref.owner, assembly.occurrences[image.copy]
        number = re.search(r"<(\d+)>\s*$", copied.names[-1])
        name = f"{name} <{number[1] if number else image.number + 2}>"
        names = assembly.occurrences[owner].names if owner else ()
        inner = owner[: len(image.series.pattern.owner) + 1] in image.series.pattern.copies
        ref = replace(source.ref, name=name, copy="/".join(image.copy[0 if inner else len(owner) :]))
        return replace(source, ref=ref, title="/".join((*names, name)), entities=entities)

    def _entity(self, entity: Entity, place: Path, image: Image, copied: bool) -> Entity:
        """Returns the entity as its image moves it, on the occurrence `place`; `copied`: whether that is in
        the copy."""
        if copied and image.by_transform:
            return replace(entity, path=place)
        place_from_world = inverse(self.assembly.world_from_path(place))
        return Entity(place, frozen(place_from_world @ image.motion @ self.assembly.world_from(entity)))

    def welded(self, mate: Mate) -> Mate:
        """Returns a FASTENED mate in its place, at the saved pose."""
        first, second = mate.entities
        second_from_world = inverse(self.assembly.world_from_path(second.path))
        entity = Entity(second.path, frozen(second_from_world @ self.assembly.world_from(first)))
        return replace(mate, ref=replace(mate.ref, type="FASTENED"), entities=(first, entity), limits={})

    def report_relations(self) -> None:
        """Reports W-PATTERN-RELATION for relations of mates that are copied, or that are in a copied
        sub-assembly."""
        for relation in self.assembly.relations:
            copied_below = [
                path[:depth]
                for path, _ in relation.mates
                for depth in range(len(relation.owner) + 1, len(path) + 1)
            ]
            is_inside = any(
                series.unsupported_copies and series.pattern.owner == relation.owner
                for path in copied_below
                for series in self.by_seed.get(path, ())
            )
            if is_inside or any(mate in self.repeated for mate in relation.mates):
                message = "a pattern or mirror repeats its joints, but the copies are not related"
                self.log.report("W-PATTERN-RELATION", message, relation.title, "mate and relate the copies")

    def report_joints(self, weld: bool) -> None:
        """Reports I-PATTERN for each pattern with copied joints, I-PATTERN-CARRIED for joints that are not
        copied."""
        for series in self.series:
            if series.carrying_mate_titles:
                message = (
                    f"its seed is fastened, and so are the copies; the mates of the parts "
                    f"that the seed carries are not copied: {name_list(sorted(series.carrying_mate_titles))}"
                )
                hint = "mate the copies themselves to what they carry"
                self.log.report("I-PATTERN-CARRIED", message, series.pattern.title, hint)
            joints, copies = series.joint_count, len(series.copies_with_joints)
            if not joints:
                continue
            instances = count(copies, "instance")
            message = (
                f"{instances} welded in place of {count(joints, 'joint')} (mirror: weld)"
                if weld
                else f"{count(joints, 'joint')} copied for {instances}, independent of the seed's"
            )
            self.log.report("I-PATTERN", message, series.pattern.title)


def _holding_mates(mates: Iterable[tuple[Mate, _Image]], groups: Iterable[_Image]) -> list[Mate]:
    """Returns the copied mates that are used when copies are welded.

    Connected copies are welded to the rest by a single mate: several would also freeze the joints between the
    copies. FASTENED mates stay.
    """
    origin: Path = ()
    rigid_groups = nx.utils.UnionFind([origin])
    for image in groups:
        rigid_groups.union(*image.target_copies, *(() if image.inside else (origin,)))

    def weld_order(copy: tuple[Mate, _Image]) -> tuple[object, ...]:
        mate, image = copy
        return mate.ref.type != "FASTENED", not image.inside, mate.title, mate.key

    holding_mates = []
    for mate, image in sorted(mates, key=weld_order):
        if mate.ref.type == "FASTENED" or image.inside or rigid_groups[image.copy] != rigid_groups[origin]:
            rigid_groups.union(*image.target_copies, *(() if image.inside else (origin,)))
            holding_mates.append(mate)
    return holding_mates
