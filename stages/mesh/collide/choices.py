"""Who makes the collider of each part: the maker of `mesh.collider`, or what a glob says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from linkwright.stages.mesh import BY_CONTACT, COLLIDERS, GIVEN, Maker
from linkwright.stages.mesh.configuration.collider_settings import ColliderSettings

if TYPE_CHECKING:
    from linkwright.stages.mesh.configuration.collider_section import ColliderSection
    from linkwright.stages.mesh.section import MeshSection

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


def default_choice(section: MeshSection) -> Choice:
    """The maker of `mesh.collider`."""
    return Choice.of(section.collider, dict(section))


def chosen_by(section: MeshSection) -> dict[str, Choice]:
    """The makers that globs ask for."""
    return {glob: _choice(section, keys, n) for n, (glob, keys) in enumerate(section.colliders.items())}


def _choice(section: MeshSection, keys: ColliderSection, number: int) -> Choice:
    own = {name: value for name, value in keys if name in _OWN and value is not None}
    values = {**dict(section), **own, "coacd": {**section.coacd, **keys.coacd}}
    primitive = keys.primitive()
    if primitive is not None:
        kind, size = primitive
        return Choice.of("given", {**values, "kind": kind, "size": size}, number)
    return Choice.of("visual" if keys.make in ("none", None) else str(keys.make), values, number)
