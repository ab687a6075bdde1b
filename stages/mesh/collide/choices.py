"""Defines the choices of collider makers that `mesh.collider` and the globs in `mesh.colliders` make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from linkwright.stages.mesh import BY_CONTACT, COLLIDERS, GIVEN, Maker
from linkwright.stages.mesh.configuration.collider_settings import ColliderSettings

if TYPE_CHECKING:
    from linkwright.stages.mesh.configuration.collider_section import ColliderSection
    from linkwright.stages.mesh.section import MeshSection
    from linkwright.stages.targets.engines import ShapeLimits

_OVERRIDING_KEYS = ("tolerance", "extra_volume", "max_vertices")
"""Keys of `mesh.colliders` that override the keys of `mesh` with the same names."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A chosen maker of colliders, with its settings."""

    maker: str
    """Name of the maker."""
    how: Maker
    """Description of the maker: for parts or links, its settings' type, its steps."""
    settings: ColliderSettings
    entry: int = -1
    """Index of the glob in `mesh.colliders` that chose the maker; -1 for `mesh.collider`."""
    apart: bool = False
    """Whether the part has a collider of its own, since the glob names the part and not its link."""

    @staticmethod
    def of(maker: str, values: Mapping[str, Any], entry: int = -1) -> Choice:
        """Returns the choice of a maker; `values`: the settings of all makers, by name. The ladder of
        `mesh.collider` goes by contact if there is no tolerance."""
        by_contact = maker == "ladder" and entry < 0 and values["tolerance"] is None
        how = BY_CONTACT if by_contact else GIVEN if maker == "given" else COLLIDERS[maker]
        return Choice(maker, how, how.settings.of(values), entry)

    @property
    def by_contact(self) -> bool:
        return self.how is BY_CONTACT


def default_choice(section: MeshSection, limits: ShapeLimits) -> Choice:
    """Returns the choice of `mesh.collider`, within the limits of the targets."""
    return Choice.of(section.collider, _with_limits(limits, dict(section)))


def choices_by_glob(section: MeshSection, limits: ShapeLimits) -> dict[str, Choice]:
    """Returns the choice of each glob in `mesh.colliders`, within the limits of the targets."""
    return {
        glob: _choice(section, keys, limits, number)
        for number, (glob, keys) in enumerate(section.colliders.items())
    }


def _with_limits(limits: ShapeLimits, values: dict[str, Any]) -> dict[str, Any]:
    return {**values, "limits": limits, "max_vertices": limits.vertices(values["max_vertices"])}


def _choice(section: MeshSection, keys: ColliderSection, limits: ShapeLimits, number: int) -> Choice:
    overrides = {name: value for name, value in keys if name in _OVERRIDING_KEYS and value is not None}
    values = _with_limits(limits, {**dict(section), **overrides, "coacd": {**section.coacd, **keys.coacd}})
    primitive = keys.primitive()
    if primitive is not None:
        kind, size = primitive
        return Choice.of("given", {**values, "kind": kind, "size": size}, number)
    return Choice.of("visual" if keys.make in ("none", None) else str(keys.make), values, number)
