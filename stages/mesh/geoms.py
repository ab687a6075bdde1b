"""The properties of contact that `geoms` gives the shapes of links and of CAD parts."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.mesh.part_choices import PartChoice, contact_of
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Shape

if TYPE_CHECKING:
    from linkwright.stages.mesh.configuration.geom_section import GeomSection


def with_properties(
    shapes: Sequence[Shape],
    chosen: Mapping[tuple[str, int], PartChoice],
    geoms: Mapping[str, "GeomSection"],
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
