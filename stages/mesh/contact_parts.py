"""Decides which parts with a mesh take part in contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

from linkwright.stages.mesh.configuration.collider_settings import default_tolerance
from linkwright.stages.mesh.link_mesh import LinkParts
from linkwright.stages.mesh.part_choices import PartChoice
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.robot import Link, Part
from linkwright.stages.robot.text.plural import count

SHAPE_DECLARING_KINDS = ("urdf", "mjcf")
"""Kinds of sources that declare collision shapes."""

_MAX_LISTED = 20
"""Largest number of parts that a diagnostic lists."""


def with_basis(link: Link, kind: str, basis: Literal["declared", "visual"], as_is: bool = False) -> Link:
    """Returns the link with only those parts and primitives marked as colliding that become its colliders.

    For a URDF or an MJCF these are the declared collision shapes, or the visual shapes if `basis` is visual
    or the link has no collision shapes. `kind`: kind of the bundle; `as_is`: whether the source itself says
    what collides, so that visual shapes replace missing collision shapes only if `basis` is visual.
    """
    if kind not in SHAPE_DECLARING_KINDS or (as_is and basis == "declared"):
        return link
    declared = any(part.collides for part in link.parts) or any(shape.collision for shape in link.shapes)
    if basis == "declared" and declared:
        return link
    parts = tuple(replace(part, collides=part.seen) for part in link.parts)
    shapes = tuple(replace(shape, collision=shape.visual) for shape in link.shapes)
    return replace(link, parts=parts, shapes=shapes)


def too_small(
    parts: Sequence[Part], link_parts: LinkParts, choices: Sequence[PartChoice], min_size: float | None
) -> frozenset[int]:
    """Returns the indices of the colliding parts that get no collider: standard content, and parts smaller
    than `min_size` [m]; no index if the link has no other parts. `link_parts`, `choices`: the findings and
    the choices of the parts, in their order."""
    colliding = [
        index
        for index, (choice, finding) in enumerate(zip(choices, link_parts.findings, strict=True))
        if choice.collides and finding.found
    ]
    minimum = default_tolerance(link_parts.diagonal) if min_size is None else min_size
    small = frozenset(
        index
        for index in colliding
        if choices[index].maker.entry < 0
        and (parts[index].standard or link_parts.findings[index].diagonal < minimum)
    )
    return small if len(small) < len(colliding) else frozenset()


def small_part_reports(small: Mapping[str, Sequence[str]]) -> list[Diagnostic]:
    """Reports I-SMALL-PARTS with the parts that have no collider. `small`: link → names of these parts."""
    labels = [f"{name} of {link}" for link, names in small.items() for name in sorted(names)]
    if not labels:
        return []
    more = f" and {len(labels) - _MAX_LISTED} more" if len(labels) > _MAX_LISTED else ""
    return [
        Diagnostic(
            "I-SMALL-PARTS",
            f"{count(len(labels), 'part')} of standard content or too small to matter have no collider: "
            f"{', '.join(labels[:_MAX_LISTED])}{more}",
            "mesh.min_size",
            "name a part in mesh.colliders to give it one; mesh.min_size=0 leaves out standard content alone",
        )
    ]
