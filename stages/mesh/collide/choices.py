"""Who makes the collider of each part: the maker of `mesh.collider`, or what a glob says."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from linkwright.stages.mesh import BY_CONTACT, COLLIDERS, GIVEN, Maker
from linkwright.stages.mesh.collide.unmatched import report_unmatched
from linkwright.stages.mesh.configuration.collider_settings import ColliderSettings
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Link, Part
from linkwright.stages.robot.text.globs import fits, unnumbered

if TYPE_CHECKING:
    from linkwright.stages.mesh.configuration.collider_section import ColliderSection
    from linkwright.stages.mesh.section import MeshSection

_WHERE = "mesh.colliders"


@dataclass(frozen=True, slots=True)
class Choice:
    """A maker, its settings, and who asked for it.

    `entry`: the number of the glob, -1 for `mesh.collider`; `apart`: whether the glob named the part and not
    its link, so that the part is on its own.
    """

    maker: str
    settings: ColliderSettings
    entry: int = -1
    apart: bool = False

    @property
    def by_contact(self) -> bool:
        """Whether contact decides, and no tolerance: where nobody asks for a part or for a tolerance."""
        return self.maker == "ladder" and self.entry < 0 and self.settings.tolerance is None

    @property
    def how(self) -> Maker:
        if self.by_contact:
            return BY_CONTACT
        return GIVEN if self.maker == "given" else COLLIDERS[self.maker]


def choices(
    links: Sequence[Link], section: MeshSection, log: Diagnostics
) -> Mapping[tuple[str, int], Choice]:
    """For each link's name and the index of each of its parts, the choice; later globs win.

    E-GLOB for each glob that matches no link and no part.
    """
    default = Choice(section.collider, ColliderSettings.of(section))
    entries = [(glob, _choice(default, keys, number)) for number, (glob, keys) in _numbered(section)]
    unmatched = {glob for glob, _ in entries}
    found: dict[tuple[str, int], Choice] = {}
    for link in links:
        for index, part in enumerate(link.parts):
            found[link.name, index] = default
            for glob, choice in entries:
                whole = fits(link.name, glob)
                if whole or any(fits(name, glob) for name in names_of(part)):
                    found[link.name, index] = replace(choice, apart=not whole)
                    unmatched.discard(glob)
        for glob in list(unmatched):
            if fits(link.name, glob):
                unmatched.discard(glob)
    for glob, _ in entries:
        if glob in unmatched:
            report_unmatched(glob, links, _WHERE, log)
    return found


def names_of(part: Part) -> tuple[str, ...]:
    """The names by which a glob may mean a part: its path in words, and its own name with and without the
    number of the instance."""
    own = part.name.rpartition("/")[2]
    return part.name, own, unnumbered(own)


def _numbered(section: MeshSection) -> Iterator[tuple[int, tuple[str, ColliderSection]]]:
    return iter(enumerate(section.colliders.items()))


def _choice(default: Choice, keys: ColliderSection, number: int) -> Choice:
    given = {
        name: value
        for name in ("tolerance", "extra_volume", "max_vertices")
        if (value := getattr(keys, name)) is not None
    }
    settings = replace(default.settings, **given, coacd={**default.settings.coacd, **keys.coacd})
    primitive = keys.primitive()
    if primitive is not None:
        kind, size = primitive
        return Choice("given", replace(settings, kind=kind, size=size), number)
    return Choice("visual" if keys.make in ("none", None) else str(keys.make), settings, number)
