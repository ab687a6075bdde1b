"""Chooses for each part whether it is seen and solid, the maker of its collider, and the collider's contact.

Globs on names of links and CAD parts are matched here.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from linkwright.stages.mesh import COLLIDERS
from linkwright.stages.mesh.collide.choices import Choice, choices_by_glob, default_choice
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings, HullSettings
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.geom_form import PLAIN, ContactProperties
from linkwright.stages.robot.model.geometry import Role, Shape
from linkwright.stages.robot.model.robot import Link, Part
from linkwright.stages.robot.text.globs import matches_glob, no_match_hint, without_number
from linkwright.stages.targets.engines import shape_limits

if TYPE_CHECKING:
    from linkwright.stages.mesh.configuration.geom_section import GeomSection
    from linkwright.stages.mesh.section import IgnoreSection, MeshSections
    from linkwright.stages.targets.engines import ShapeLimits

_MAX_ELLIPSOID_VERTICES = 10_000
"""Largest number of vertices of the hull of an ellipsoid: more than its mesh has, so that all are kept."""


@dataclass(frozen=True, slots=True)
class PartChoice:
    """The choices of the configuration for a part."""

    collides: bool
    """Whether the part takes part in contact."""
    seen: bool
    """Whether the part is drawn."""
    maker: Choice
    """Maker of the part's collider."""
    contact: Mapping[str, Any]
    """Contact properties of the collider that `geoms` sets, by MuJoCo's names."""


def part_choices(
    links: Sequence[Link], keys: MeshSections, as_is: bool, log: Diagnostics
) -> dict[tuple[str, int], PartChoice]:
    """Returns the choices for each part, by its link's name and its index in the link; later globs win.
    Reports E-GLOB for each glob that matches no link and no part. `as_is`: whether the source itself says
    what collides."""
    ignore = keys.ignore
    _report_unmatched(keys.geoms, "geoms", links, log)
    _report_unmatched(ignore.visual, "ignore.visual", links, log)
    _report_unmatched(ignore.collision, "ignore.collision", links, log)
    _report_unmatched(keys.mesh.colliders, "mesh.colliders", links, log)
    by_source = as_is and keys.mesh.basis == "declared"
    limits = shape_limits(keys.target.chosen)
    default = default_choice(keys.mesh, limits)
    entries = choices_by_glob(keys.mesh, limits)
    choices = {}
    for link in links:
        for index, part in enumerate(link.parts):
            maker = default
            for glob in _matching(entries, link.name, part):
                maker = replace(entries[glob], apart=not matches_glob(link.name, glob))
            contact = contact_of(keys.geoms, link.name, "collision", part)
            is_contact_separate = any(
                not matches_glob(link.name, glob) and keys.geoms[glob].collision.model_dump(exclude_none=True)
                for glob in _matching(keys.geoms, link.name, part)
            )
            choices[link.name, index] = PartChoice(
                part.collides and not _matching(ignore.collision, link.name, part),
                part.seen and not _matching(ignore.visual, link.name, part),
                _with_part_maker(maker, part, is_contact_separate, by_source, limits),
                contact,
            )
    return choices


def with_shown_shapes(link: Link, keys: IgnoreSection) -> Link:
    """Returns the link, its primitives hidden or without contact if `ignore` names the link."""
    seen, solid = (not _matching(globs, link.name) for globs in (keys.visual, keys.collision))
    if seen and solid:
        return link
    shapes = (
        replace(shape, visual=shape.visual and seen, collision=shape.collision and solid)
        for shape in link.shapes
    )
    return replace(link, shapes=tuple(shapes))


def contact_of(
    geoms: Mapping[str, GeomSection], link: str, role: Role, part: Part | None = None
) -> dict[str, Any]:
    """Returns the properties that `geoms` sets for the shapes of a link, or of a part of it, in a role. Later
    entries win, property by property."""
    properties: dict[str, Any] = {}
    for glob in _matching(geoms, link, part):
        properties |= getattr(geoms[glob], role).model_dump(exclude_none=True)
    return properties


def _matching(globs: Collection[str], link: str, part: Part | None = None) -> list[str]:
    """Returns the globs that match a link, or the given part of it: the part's whole path, or its last name
    with or without the number of the instance."""
    names = [link]
    if part is not None and globs:
        part_name = part.name.rpartition("/")[2]
        names += [part.name, part_name, without_number(part_name)]
    return [glob for glob in globs if any(matches_glob(name, glob) for name in names)]


def _report_unmatched(globs: Collection[str], where: str, links: Sequence[Link], log: Diagnostics) -> None:
    """Reports E-GLOB at the key `where` for each glob that matches no link and no part. The hint has the
    nearest name, and lists all names."""
    for glob in dict.fromkeys(globs):
        if any(_matching((glob,), link.name, part) for link in links for part in (None, *link.parts)):
            continue
        parts = {without_number(part.name.rpartition("/")[2]) for link in links for part in link.parts}
        hint = no_match_hint(glob, {"links": [link.name for link in links], "parts": sorted(parts)})
        log.report_unmatched("E-GLOB", f"no link and no part matches {glob!r}", where, hint, glob)


def _with_part_maker(
    choice: Choice, part: Part, has_own_contact: bool, declared: bool, limits: ShapeLimits
) -> Choice:
    """Returns the choice of the maker, adapted to a part. An ellipsoid that `mesh.colliders` does not name
    becomes its hull, with as many vertices as the `limits` allow. A collider that an MJCF source declares
    (`declared`) becomes its hull, as MuJoCo uses it, unless the configuration asks for another collider.
    `has_own_contact`: whether the part needs a collider of its own since `geoms` names it."""
    settings = choice.settings
    if part.form.ellipsoid and choice.entry < 0:
        settings = HullSettings(limits.vertices(_MAX_ELLIPSOID_VERTICES))
    elif declared and isinstance(settings, ContactSettings):
        settings = HullSettings(settings.max_vertices)
    else:
        return replace(choice, apart=choice.apart or has_own_contact or part.form != PLAIN)
    return replace(choice, maker="hull", how=COLLIDERS["hull"], settings=settings, apart=True)


def with_properties(
    shapes: Sequence[Shape],
    choice_of: Mapping[tuple[str, int], PartChoice],
    geoms: Mapping[str, GeomSection],
    by_source: bool = False,
) -> tuple[Shape, ...]:
    """Returns the shapes with their contact properties: the properties of an MJCF source, overridden by those
    that `geoms` sets for the link and role, or for the part. `choice_of`: the choice for the parts of each
    collider, by link and index; `by_source`: whether the source says what collides."""

    def contact_of_shape(shape: Shape) -> ContactProperties | None:
        key = shape.link, -1 if shape.collider is None else shape.collider
        contact = choice_of[key].contact if key in choice_of else contact_of(geoms, shape.link, shape.role)
        from_source = _contact_of_source(shape, by_source)
        return replace(from_source or ContactProperties(), **contact) if contact else from_source

    return tuple(replace(shape, contact=contact_of_shape(shape)) for shape in shapes)


def _contact_of_source(shape: Shape, by_source: bool) -> ContactProperties | None:
    """Returns a shape's contact properties in an MJCF source; the bits only if they decide what collides."""
    contact = shape.form.contact
    if contact is None or by_source:
        return contact
    without_bits = replace(contact, contype=None, conaffinity=None)
    return without_bits if without_bits.given() else None
