"""Which parts take part in contact, of those that have a mesh."""

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

FILES = ("urdf", "mjcf")
"""The kinds of bundle that declare collision shapes of their own."""

_SHOWN = 20


def with_basis(link: Link, kind: str, basis: Literal["declared", "visual"], as_is: bool = False) -> Link:
    """A link whose colliding parts and primitives are those that its colliders are made of.

    `kind`: of the bundle. A file's own collision shapes, or its visual ones where it has none of the others;
    `as_is`: only its own, since it says itself what collides.
    """
    if kind not in FILES or (as_is and basis == "declared"):
        return link
    declared = any(part.collides for part in link.parts) or any(one.collision for one in link.shapes)
    if basis == "declared" and declared:
        return link
    parts = tuple(replace(part, collides=part.seen) for part in link.parts)
    shapes = tuple(replace(one, collision=one.visual) for one in link.shapes)
    return replace(link, parts=parts, shapes=shapes)


def too_small(
    parts: Sequence[Part], known: LinkParts, chosen: Sequence[PartChoice], min_size: float | None
) -> frozenset[int]:
    """The indices of the colliding parts that have no collider: standard content and what is smaller than
    `min_size` [m]; none where the link has nothing else. `known`, `chosen`: the findings and the choices of
    the parts, in their order."""
    colliding = [
        index
        for index, (own, found) in enumerate(zip(chosen, known.findings, strict=True))
        if own.collides and found.found
    ]
    least = default_tolerance(known.diagonal) if min_size is None else min_size
    small = frozenset(
        index
        for index in colliding
        if chosen[index].maker.entry < 0 and (parts[index].standard or known.findings[index].diagonal < least)
    )
    return small if len(small) < len(colliding) else frozenset()


def reported(small: Mapping[str, Sequence[str]]) -> list[Diagnostic]:
    """I-SMALL-PARTS with the names of the parts, by link, that have no collider."""
    named = [f"{name} of {link}" for link, names in small.items() for name in sorted(names)]
    if not named:
        return []
    more = f" and {len(named) - _SHOWN} more" if len(named) > _SHOWN else ""
    return [
        Diagnostic(
            "I-SMALL-PARTS",
            f"{count(len(named), 'part')} of standard content or too small to matter have no collider: "
            f"{', '.join(named[:_SHOWN])}{more}",
            "mesh.min_size",
            "name a part in mesh.colliders to give it one; mesh.min_size=0 leaves out standard content alone",
        )
    ]
