"""What is asked of each part: whether it is seen and solid, who makes its collider, and the contact of that.

Globs on names of links and CAD parts are matched here.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from linkwright.stages.mesh import COLLIDERS
from linkwright.stages.mesh.collide.choices import Choice, chosen_by, default_choice
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings, HullSettings
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.geom_form import PLAIN, ContactProperties
from linkwright.stages.robot.model.geometry import Role, Shape
from linkwright.stages.robot.model.robot import Link, Part
from linkwright.stages.robot.text.globs import fits, there_are, unnumbered

if TYPE_CHECKING:
    from linkwright.stages.mesh.configuration.geom_section import GeomSection
    from linkwright.stages.mesh.section import IgnoreSection, MeshSections

_MOST_CORNERS = 10_000
"""Of the hull of an ellipsoid: as many as it has."""


@dataclass(frozen=True, slots=True)
class PartChoice:
    """Whether a part takes part in contact, and is drawn; who makes its collider; and what `geoms` says of
    the contact of that, by MuJoCo's names."""

    collides: bool
    seen: bool
    maker: Choice
    contact: Mapping[str, Any]


def part_choices(
    links: Sequence[Link], keys: MeshSections, as_is: bool, log: Diagnostics
) -> dict[tuple[str, int], PartChoice]:
    """By each link's name and the index of each of its parts; later globs win. `as_is`: whether the source
    says itself what collides. E-GLOB for each glob that matches no link and no part."""
    ignore = keys.ignore
    _report_unmatched(keys.geoms, "geoms", links, log)
    _report_unmatched(ignore.visual, "ignore.visual", links, log)
    _report_unmatched(ignore.collision, "ignore.collision", links, log)
    _report_unmatched(keys.mesh.colliders, "mesh.colliders", links, log)
    own = as_is and keys.mesh.basis == "declared"
    default = default_choice(keys.mesh)
    entries = chosen_by(keys.mesh)
    found = {}
    for link in links:
        for index, part in enumerate(link.parts):
            maker = default
            for glob in _meaning(entries, link.name, part):
                maker = replace(entries[glob], apart=not fits(link.name, glob))
            contact = contact_of(keys.geoms, link.name, "collision", part)
            apart = any(
                not fits(link.name, glob) and keys.geoms[glob].collision.model_dump(exclude_none=True)
                for glob in _meaning(keys.geoms, link.name, part)
            )
            found[link.name, index] = PartChoice(
                part.collides and not _meaning(ignore.collision, link.name, part),
                part.seen and not _meaning(ignore.visual, link.name, part),
                _maker(maker, part, apart, own),
                contact,
            )
    return found


def with_shown_shapes(link: Link, keys: IgnoreSection) -> Link:
    """The link, whose primitives are neither drawn nor solid where `ignore` names it."""
    seen, solid = (not _meaning(globs, link.name) for globs in (keys.visual, keys.collision))
    if seen and solid:
        return link
    shapes = (
        replace(one, visual=one.visual and seen, collision=one.collision and solid) for one in link.shapes
    )
    return replace(link, shapes=tuple(shapes))


def contact_of(
    geoms: Mapping[str, GeomSection], link: str, role: Role, part: Part | None = None
) -> dict[str, Any]:
    """What `geoms` says of the shapes of a link in a role, or of one of its parts: later entries win,
    property by property."""
    found: dict[str, Any] = {}
    for glob in _meaning(geoms, link, part):
        found |= getattr(geoms[glob], role).model_dump(exclude_none=True)
    return found


def _meaning(globs: Collection[str], link: str, part: Part | None = None) -> list[str]:
    """Those of the globs that mean a link, or this part of it: by its path in words, or its own name with or
    without the number of the instance."""
    names = [link]
    if part is not None and globs:
        own = part.name.rpartition("/")[2]
        names += [part.name, own, unnumbered(own)]
    return [glob for glob in globs if any(fits(name, glob) for name in names)]


def _report_unmatched(globs: Collection[str], where: str, links: Sequence[Link], log: Diagnostics) -> None:
    """E-GLOB at the key `where` for each that means no link and no part, with the nearest name and all there
    are."""
    for glob in dict.fromkeys(globs):
        if any(_meaning((glob,), link.name, part) for link in links for part in (None, *link.parts)):
            continue
        parts = {unnumbered(part.name.rpartition("/")[2]) for link in links for part in link.parts}
        hint = there_are(glob, {"links": [link.name for link in links], "parts": sorted(parts)})
        log.unmatched("E-GLOB", f"no link and no part matches {glob!r}", where, hint, glob)


def _maker(choice: Choice, part: Part, apart: bool, own: bool) -> Choice:
    """Who makes the collider of a part: of an ellipsoid its hull, with all of its corners; of what an MJCF
    source says itself (`own`), the hull that MuJoCo takes of it, where nothing else is asked for."""
    settings = choice.settings
    if part.form.ellipsoid:
        settings = HullSettings(_MOST_CORNERS)
    elif own and isinstance(settings, ContactSettings):
        settings = HullSettings(settings.max_vertices)
    else:
        return replace(choice, apart=choice.apart or apart or part.form != PLAIN)
    return replace(choice, maker="hull", how=COLLIDERS["hull"], settings=settings, apart=True)


def with_properties(
    shapes: Sequence[Shape],
    chosen: Mapping[tuple[str, int], PartChoice],
    geoms: Mapping[str, GeomSection],
    by_source: bool = False,
) -> tuple[Shape, ...]:
    """The shapes, each with the properties of its link and role, or of its part, after those of an MJCF
    source. `chosen`: by link and number what is asked of the parts of each collider, which is the same of
    all; `by_source`: whether the source says what collides."""

    def of(shape: Shape) -> ContactProperties | None:
        key = shape.link, -1 if shape.collider is None else shape.collider
        given = chosen[key].contact if key in chosen else contact_of(geoms, shape.link, shape.role)
        found = _of_source(shape, by_source)
        return replace(found or ContactProperties(), **given) if given else found

    return tuple(replace(shape, contact=of(shape)) for shape in shapes)


def _of_source(shape: Shape, by_source: bool) -> ContactProperties | None:
    """What an MJCF source says of a shape's contacts: its bits only where they decide what collides."""
    contact = shape.form.contact
    if contact is None or by_source:
        return contact
    without = replace(contact, contype=None, conaffinity=None)
    return without if without.given() else None
