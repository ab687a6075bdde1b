"""Collects the parts of each link that have a mesh, and makes the link's visual meshes from them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from linkwright.stages.mesh import link_mesh
from linkwright.stages.mesh.collide.make import ColliderJob, MadeCollider, collider_indices, jobs_of
from linkwright.stages.mesh.contact_parts import too_small
from linkwright.stages.mesh.library import MeshLibrary
from linkwright.stages.mesh.link_mesh import LinkParts, PartFinding, PlacedMesh
from linkwright.stages.mesh.part_choices import PartChoice
from linkwright.stages.mesh.visuals.make import LinkVisuals
from linkwright.stages.robot import codec
from linkwright.stages.robot.model.robot import Link, Part

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo
    from linkwright.stages.mesh.section import MeshSection


@dataclass(frozen=True, slots=True, eq=False)
class LinkUses:
    """The parts of a link that have a mesh. They are sorted by content, so that cached results stay valid if
    instances are renamed or reordered."""

    parts: tuple[Part, ...]
    uses: tuple[PlacedMesh, ...]
    """Mesh and pose of each part."""
    choices: tuple[PartChoice, ...]
    """The choices for each part."""
    link_parts: LinkParts
    """Findings about the meshes of the parts."""
    small: frozenset[int]
    """Indices of the parts that are too small for a collider."""

    def jobs(self, link: str) -> Iterator[ColliderJob]:
        """Yields the jobs of the link's colliders."""
        colliding = [
            index
            for index, (use, finding) in enumerate(zip(self.uses, self.link_parts.findings, strict=True))
            if use.collides and finding.found and index not in self.small
        ]
        uses = [self.uses[index] for index in colliding]
        names = [self.parts[index].name for index in colliding]
        for job in jobs_of(link, uses, names, [self.choices[index].maker for index in colliding]):
            yield replace(job, parts=tuple(colliding[index] for index in job.parts))

    def parts_of(self, job: ColliderJob) -> list[Part]:
        """Returns the parts of the link for which a job makes a collider. A collider that `mesh.colliders`
        chose is no ellipsoid, whatever its part is."""
        parts = [self.parts[index] for index in job.parts]
        if job.choice.entry < 0:
            return parts
        return [replace(part, form=replace(part.form, ellipsoid=())) for part in parts]


def used_meshes(
    links: Sequence[Link],
    library: MeshLibrary,
    choice_of: Mapping[tuple[str, int], PartChoice],
    memo: "Memo",
    min_size: float | None,
    as_is: bool,
) -> dict[str, LinkUses]:
    """Returns the parts of each link that have a mesh, by the link's name. `min_size`: see `too_small`;
    `as_is`: whether the source itself says what collides."""
    uses_by_link = {}
    for link in links:
        triples = []
        for index, part in enumerate(link.parts):
            choice = choice_of[link.name, index]
            if part.mesh:
                use = PlacedMesh(part.mesh, part.link_from_part, choice.collides, choice.seen)
                triples.append((use, part, choice))
        triples.sort(key=lambda triple: triple[0].key())
        uses, parts, choices = zip(*triples, strict=True) if triples else ((), (), ())
        link_parts = _link_parts(uses, library, memo)
        small = frozenset[int]() if as_is else too_small(parts, link_parts, choices, min_size)
        uses_by_link[link.name] = LinkUses(parts, uses, choices, link_parts, small)
    return uses_by_link


def link_visuals(
    uses_by_link: Mapping[str, LinkUses], library: MeshLibrary, section: "MeshSection", memo: "Memo"
) -> dict[str, LinkVisuals]:
    """Returns the visual meshes of each link, by the link's name."""

    def visuals_of_link(uses: Sequence[PlacedMesh]) -> LinkVisuals:
        def make() -> bytes:
            meshes = library.meshes(use.mesh for use in uses)
            return link_mesh.encode(link_mesh.visuals_of(uses, meshes, section.visual, library.decimator))

        key = {"visual": section.visual.identity(), "parts": [use.key() for use in uses]}
        return link_mesh.decode(memo("mesh.link", key, make)) if uses else LinkVisuals((), (), None)

    return {name: visuals_of_link(link.uses) for name, link in uses_by_link.items()}


def choices_by_collider(
    made_colliders: Sequence[MadeCollider], uses_by_link: Mapping[str, LinkUses]
) -> dict[tuple[str, int], PartChoice]:
    """Returns the choice for the first part of each collider, by link and index of the collider in it. Parts
    that share a collider have the same choice of contact."""
    return {
        (collider.job.link, index): uses_by_link[collider.job.link].choices[collider.job.parts[0]]
        for collider, index in zip(made_colliders, collider_indices(made_colliders), strict=True)
    }


def part_findings(link: Link, uses: LinkUses) -> list[tuple[Part, PartFinding]]:
    """Returns all parts of a link with the findings about their meshes, parts without a mesh last."""
    bare_parts = [(part, PartFinding(found=False, volume=None)) for part in link.parts if part.mesh is None]
    return [*zip(uses.parts, uses.link_parts.findings, strict=True), *bare_parts]


def small_part_names(uses_by_link: Mapping[str, LinkUses]) -> dict[str, list[str]]:
    """Returns the names of the parts that are too small for a collider, for each link that has such parts."""
    return {
        link: [uses.parts[index].name for index in uses.small]
        for link, uses in uses_by_link.items()
        if uses.small
    }


def _link_parts(uses: Sequence[PlacedMesh], library: MeshLibrary, memo: "Memo") -> LinkParts:
    if not uses:
        return LinkParts(())

    def make() -> bytes:
        return codec.dump(LinkParts.of(uses, library.meshes(use.mesh for use in uses)))

    return codec.load(LinkParts, memo("mesh.parts", {"parts": [use.key() for use in uses]}, make))
