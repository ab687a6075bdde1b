"""The parts of each link that have a mesh, and the visual meshes that are made of them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from linkwright.stages.mesh import link_mesh
from linkwright.stages.mesh.collide.make import ColliderJob, jobs_of
from linkwright.stages.mesh.contact_parts import too_small
from linkwright.stages.mesh.library import MeshLibrary
from linkwright.stages.mesh.link_mesh import LinkParts, Use
from linkwright.stages.mesh.part_choices import PartChoice
from linkwright.stages.mesh.visuals.make import LinkVisuals
from linkwright.stages.robot import codec
from linkwright.stages.robot.model.robot import Link, Part

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo
    from linkwright.stages.mesh.section import MeshSection


@dataclass(frozen=True, slots=True, eq=False)
class LinkUses:
    """The parts of a link that have a mesh, sorted by content: neither a new name nor another order of
    instances makes the work again. `chosen`: what is asked of each."""

    parts: tuple[Part, ...]
    uses: tuple[Use, ...]
    chosen: tuple[PartChoice, ...]
    known: LinkParts
    small: frozenset[int]

    def jobs(self, link: str) -> Iterator[ColliderJob]:
        """What of the link has a collider."""
        colliding = [
            index
            for index, (use, found) in enumerate(zip(self.uses, self.known.findings, strict=True))
            if use.collides and found.found and index not in self.small
        ]
        uses = [self.uses[index] for index in colliding]
        names = [self.parts[index].name for index in colliding]
        for job in jobs_of(link, uses, names, [self.chosen[index].maker for index in colliding]):
            yield replace(job, parts=tuple(colliding[index] for index in job.parts))


def used_meshes(
    links: Sequence[Link],
    library: MeshLibrary,
    choice_of: Mapping[tuple[str, int], PartChoice],
    memo: "Memo",
    min_size: float | None,
    as_is: bool,
) -> dict[str, LinkUses]:
    """The parts of each link that have a mesh, by the link's name. `min_size`: see `too_small`; `as_is`:
    whether the source says itself what collides."""
    found = {}
    for link in links:
        triples = []
        for index, part in enumerate(link.parts):
            chosen = choice_of[link.name, index]
            if part.mesh:
                use = Use(part.mesh, part.link_from_part, chosen.collides, chosen.seen)
                triples.append((use, part, chosen))
        triples.sort(key=lambda triple: triple[0].key())
        uses, parts, makers = zip(*triples, strict=True) if triples else ((), (), ())
        known = _known(uses, library, memo)
        small = frozenset[int]() if as_is else too_small(parts, known, makers, min_size)
        found[link.name] = LinkUses(parts, uses, makers, known, small)
    return found


def link_visuals(
    used: Mapping[str, LinkUses], library: MeshLibrary, section: "MeshSection", memo: "Memo"
) -> dict[str, LinkVisuals]:
    """The visual meshes of each link, by its name."""

    def of_link(uses: Sequence[Use]) -> LinkVisuals:
        def make() -> bytes:
            meshes = library.meshes(use.mesh for use in uses)
            return link_mesh.encode(link_mesh.visuals_of(uses, meshes, section.visual, library.decimator))

        key = {"visual": section.visual.identity(), "parts": [use.key() for use in uses]}
        return link_mesh.decode(memo("mesh.link", key, make)) if uses else LinkVisuals((), (), None)

    return {name: of_link(link.uses) for name, link in used.items()}


def _known(uses: Sequence[Use], library: MeshLibrary, memo: "Memo") -> LinkParts:
    if not uses:
        return LinkParts(())

    def make() -> bytes:
        return codec.dump(LinkParts.of(uses, library.meshes(use.mesh for use in uses)))

    return codec.load(LinkParts, memo("mesh.parts", {"parts": [use.key() for use in uses]}, make))
