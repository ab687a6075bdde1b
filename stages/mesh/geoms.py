"""The properties of contact that `geoms` gives the shapes of links and of CAD parts."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.mesh.collide.choices import names_of
from linkwright.stages.mesh.collide.unmatched import report_unmatched
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.model.robot import Link, Part
from linkwright.stages.robot.text.globs import fits

if TYPE_CHECKING:
    from linkwright.stages.mesh.configuration.geom_section import GeomSection

_WHERE = "geoms"


class GeomRules:
    """What `geoms` says. A glob means links; or CAD parts, of which the colliders alone have properties."""

    def __init__(self, links: Sequence[Link], wanted: Mapping[str, "GeomSection"], log: Diagnostics) -> None:
        """E-GLOB for each glob that matches no link and no part."""
        self._wanted = wanted
        parts = [part for link in links for part in link.parts]
        for glob in wanted:
            named = any(fits(link.name, glob) for link in links)
            if not named and not any(_means(glob, part) for part in parts):
                report_unmatched(glob, links, _WHERE, log)

    def set_apart(self, link: str, part: Part) -> bool:
        """Whether a part has properties that its link has not: then it has a collider of its own."""
        return any(
            keys.collision.model_dump(exclude_none=True) and _means(glob, part) and not fits(link, glob)
            for glob, keys in self._wanted.items()
        )

    def with_properties(
        self,
        shapes: Sequence[Shape],
        parts: Mapping[tuple[str, int], Sequence[Part]],
        by_source: bool = False,
    ) -> tuple[Shape, ...]:
        """The shapes, each with the properties of its link and role, and of its parts, after those of an MJCF
        source. `parts`: by link and number the parts of each collider; `by_source`: whether the source says
        what collides."""
        return tuple(
            replace(shape, contact=self._of(shape, parts, _of_source(shape, by_source))) for shape in shapes
        )

    def _of(
        self,
        shape: Shape,
        parts: Mapping[tuple[str, int], Sequence[Part]],
        found: ContactProperties | None,
    ) -> ContactProperties | None:
        """Later entries win, property by property."""
        link, role = shape.link, shape.role
        own = None if shape.collider is None else parts.get((link, shape.collider))
        for glob, keys in self._wanted.items():
            given = getattr(keys, role).model_dump(exclude_none=True)
            if given and (fits(link, glob) or (own and all(_means(glob, part) for part in own))):
                found = replace(found or ContactProperties(), **given)
        return found


def _of_source(shape: Shape, by_source: bool) -> ContactProperties | None:
    """What an MJCF source says of a shape's contacts: its bits only where they decide what collides."""
    contact = shape.form.contact
    if contact is None or by_source:
        return contact
    without = replace(contact, contype=None, conaffinity=None)
    return without if without.given() else None


def _means(glob: str, part: Part) -> bool:
    return any(fits(name, glob) for name in names_of(part))
