"""Who makes the collider of each part: the maker of `mesh.collider`, or what a glob says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

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
_OWN = ("tolerance", "extra_volume", "max_vertices")


@dataclass(frozen=True, slots=True)
class Choice:
    """A maker, how it works, its settings, and who asked for it.

    `entry`: the number of the glob, -1 for `mesh.collider`; `apart`: whether the glob named the part and not
    its link, so that the part is on its own.
    """

    maker: str
    how: Maker
    settings: ColliderSettings
    entry: int = -1
    apart: bool = False

    @staticmethod
    def of(maker: str, values: Mapping[str, Any], entry: int = -1) -> Choice:
        """Of a maker and the settings of all makers by name. Contact decides, and no tolerance, where nobody
        asks for a part or for a tolerance."""
        by_contact = maker == "ladder" and entry < 0 and values["tolerance"] is None
        how = BY_CONTACT if by_contact else GIVEN if maker == "given" else COLLIDERS[maker]
        return Choice(maker, how, how.settings.of(values), entry)

    @property
    def by_contact(self) -> bool:
        return self.how is BY_CONTACT


def choices(
    links: Sequence[Link], section: MeshSection, log: Diagnostics
) -> Mapping[tuple[str, int], Choice]:
    """For each link's name and the index of each of its parts, the choice; later globs win.

    E-GLOB for each glob that matches no link and no part.
    """
    default = default_choice(section)
    numbered = enumerate(section.colliders.items())
    entries = [(glob, _choice(section, keys, number)) for number, (glob, keys) in numbered]
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


def default_choice(section: MeshSection) -> Choice:
    """The maker of `mesh.collider`."""
    return Choice.of(section.collider, dict(section))


def _choice(section: MeshSection, keys: ColliderSection, number: int) -> Choice:
    own = {name: value for name, value in keys if name in _OWN and value is not None}
    values = {**dict(section), **own, "coacd": {**section.coacd, **keys.coacd}}
    primitive = keys.primitive()
    if primitive is not None:
        kind, size = primitive
        return Choice.of("given", {**values, "kind": kind, "size": size}, number)
    return Choice.of("visual" if keys.make in ("none", None) else str(keys.make), values, number)
