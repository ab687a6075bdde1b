"""The properties of contact that `geoms` gives the shapes of links."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from stages.robot.errors import Diagnostic, MeshError
from stages.robot.geometry import ContactProperties, Role, Shape
from stages.robot.globs import fits, listed

if TYPE_CHECKING:
    from stages.mesh.geom_keys import GeomKeys

_WHERE = "geoms"

PRESET = ("*", "*foot*")
"""Globs that may match nothing: they come from our own presets (conf/robot/legged.yaml)."""

Properties = Mapping[tuple[str, Role], ContactProperties]
"""By link and role, where there are any."""


def contact_properties(links: Sequence[str], wanted: Mapping[str, "GeomKeys"]) -> Properties:
    """The properties of the links' shapes; later entries win, property by property.

    MeshError with E-GLOB for each glob that matches no link, but for those of our own presets.
    """
    hint = f"links are: {listed(links) or 'none'}"
    problems = [
        Diagnostic("E-GLOB", f"no link matches {glob!r}", _WHERE, hint)
        for glob in wanted
        if glob not in PRESET and not any(fits(link, glob) for link in links)
    ]
    if problems:
        msg = "the links whose geoms have properties cannot be found"
        raise MeshError(msg, _WHERE, problems=problems)
    found: dict[tuple[str, Role], ContactProperties] = {}
    roles: tuple[Role, ...] = ("visual", "collision")
    for link in links:
        for glob, keys in wanted.items():
            for role in roles:
                given = getattr(keys, role).model_dump(exclude_none=True)
                if given and fits(link, glob):
                    found[link, role] = replace(found.get((link, role), ContactProperties()), **given)
    return found


def with_properties(shapes: Sequence[Shape], properties: Properties) -> tuple[Shape, ...]:
    """The shapes, each with the properties of its link and role."""
    return tuple(replace(shape, contact=properties.get((shape.link, shape.role))) for shape in shapes)
