"""The properties of contact that `geoms` gives the shapes of links and of CAD parts."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from stages.mesh.choices import names_of
from stages.mesh.unmatched import report_unmatched
from stages.robot.diagnostics import Diagnostics
from stages.robot.geometry import ContactProperties, Role, Shape
from stages.robot.globs import fits
from stages.robot.model import Link, Part

if TYPE_CHECKING:
    from stages.mesh.geom_keys import GeomKeys

_WHERE = "geoms"


class GeomRules:
    """What `geoms` says. A glob means links; or CAD parts, of which the colliders alone have properties."""

    def __init__(self, links: Sequence[Link], wanted: Mapping[str, "GeomKeys"], log: Diagnostics) -> None:
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
        self, shapes: Sequence[Shape], parts: Mapping[tuple[str, int], Sequence[Part]]
    ) -> tuple[Shape, ...]:
        """The shapes, each with the properties of its link and role, and of its parts. `parts`: by link and
        number the parts of each collider."""
        return tuple(
            replace(shape, contact=self._of(shape.link, shape.role, parts.get((shape.link, shape.collider))))
            if shape.collider is not None
            else replace(shape, contact=self._of(shape.link, shape.role))
            for shape in shapes
        )

    def _of(self, link: str, role: Role, parts: Sequence[Part] | None = None) -> ContactProperties | None:
        """Later entries win, property by property."""
        found: ContactProperties | None = None
        for glob, keys in self._wanted.items():
            given = getattr(keys, role).model_dump(exclude_none=True)
            if given and (fits(link, glob) or (parts and all(_means(glob, part) for part in parts))):
                found = replace(found or ContactProperties(), **given)
        return found


def _means(glob: str, part: Part) -> bool:
    return any(fits(name, glob) for name in names_of(part))
