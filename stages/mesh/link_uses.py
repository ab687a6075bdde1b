"""The parts of each link that have a mesh, and the visual meshes that are made of them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from linkwright.stages.mesh import COLLIDERS, link_mesh
from linkwright.stages.mesh.collide.choices import Choice
from linkwright.stages.mesh.collide.make import ColliderJob, jobs_of
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings, HullSettings
from linkwright.stages.mesh.contact_parts import too_small
from linkwright.stages.mesh.geoms import GeomRules
from linkwright.stages.mesh.library import MeshLibrary
from linkwright.stages.mesh.link_mesh import LinkParts, Use
from linkwright.stages.mesh.visuals.make import LinkVisuals
from linkwright.stages.robot.model.geom_form import PLAIN
from linkwright.stages.robot.model.robot import Link, Part

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo
    from linkwright.stages.mesh.section import MeshSection

HULL = COLLIDERS["hull"]

_MOST_CORNERS = 10_000
"""Of the hull of an ellipsoid: as many as it has."""


@dataclass(frozen=True, slots=True, eq=False)
class LinkUses:
    """The parts of a link that have a mesh, sorted by content: neither a new name nor another order of
    instances makes the work again. `chosen`: who makes the collider of each."""

    parts: tuple[Part, ...]
    uses: tuple[Use, ...]
    chosen: tuple[Choice, ...]
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
        for job in jobs_of(link, uses, names, [self.chosen[index] for index in colliding]):
            yield replace(job, parts=tuple(colliding[index] for index in job.parts))


def used_meshes(
    links: Sequence[Link],
    library: MeshLibrary,
    section: "MeshSection",
    choice_of: Mapping[tuple[str, int], Choice],
    rules: GeomRules,
    memo: "Memo",
    as_is: bool,
) -> dict[str, LinkUses]:
    """The parts of each link that have a mesh, by the link's name. `as_is`: whether the source says itself
    what collides."""
    found = {}
    for link in links:
        triples = [
            (Use(part.mesh, part.link_from_part, part.collides, part.seen), part, choice_of[link.name, index])
            for index, part in enumerate(link.parts)
            if part.mesh
        ]
        triples.sort(key=lambda triple: triple[0].key())
        uses = [use for use, _, _ in triples]
        parts = [part for _, part, _ in triples]
        own = as_is and section.basis == "declared"
        makers = [_maker(maker, part, rules.set_apart(link.name, part), own) for _, part, maker in triples]
        known = _known(uses, library, memo)
        small = frozenset[int]() if as_is else too_small(parts, known, makers, section.min_size)
        found[link.name] = LinkUses(tuple(parts), tuple(uses), tuple(makers), known, small)
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
        return LinkParts.of(uses, library.meshes(use.mesh for use in uses)).encoded()

    return LinkParts.decoded(memo("mesh.parts", {"parts": [use.key() for use in uses]}, make))


def _maker(choice: Choice, part: Part, apart: bool, own: bool) -> Choice:
    """Who makes the collider of a part: of an ellipsoid its hull, with all of its corners; of what an MJCF
    source says itself (`own`), the hull that MuJoCo takes of it, where nothing else is asked for."""
    if part.form.ellipsoid:
        return replace(choice, maker="hull", how=HULL, settings=HullSettings(_MOST_CORNERS), apart=True)
    if isinstance(choice.settings, ContactSettings) and own:
        settings = HullSettings(choice.settings.max_vertices)
        return replace(choice, maker="hull", how=HULL, settings=settings, apart=True)
    return replace(choice, apart=True) if apart or part.form != PLAIN else choice
