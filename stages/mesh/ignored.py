"""Links and parts that `ignore` leaves without visual geometry or colliders. Their masses stay."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.mesh.collide.choices import names_of
from linkwright.stages.mesh.collide.unmatched import report_unmatched
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Link, Part
from linkwright.stages.robot.text.globs import fits

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import IgnoreSection


def without_ignored(links: Sequence[Link], keys: IgnoreSection, log: Diagnostics) -> list[Link]:
    """The links, whose parts and primitives are neither drawn nor solid where `ignore` says so.

    E-GLOB for each glob that matches no link and no part.
    """
    wanted = {"ignore.visual": keys.visual, "ignore.collision": keys.collision}
    for where, globs in wanted.items():
        for glob in dict.fromkeys(globs):
            if not any(_means(glob, link) for link in links):
                report_unmatched(glob, links, where, log)
    return [_without(link, keys) for link in links] if keys.visual or keys.collision else list(links)


def _without(link: Link, keys: IgnoreSection) -> Link:
    parts = tuple(
        replace(
            part,
            seen=part.seen and not _named(keys.visual, link, part),
            collides=part.collides and not _named(keys.collision, link, part),
        )
        for part in link.parts
    )
    shapes = tuple(
        replace(
            one,
            visual=one.visual and not _named(keys.visual, link),
            collision=one.collision and not _named(keys.collision, link),
        )
        for one in link.shapes
    )
    return replace(link, parts=parts, shapes=shapes)


def _named(globs: Collection[str], link: Link, part: Part | None = None) -> bool:
    """Whether one of the globs means the link, or this part of it."""
    names = (link.name, *(names_of(part) if part else ()))
    return any(fits(name, glob) for glob in globs for name in names)


def _means(glob: str, link: Link) -> bool:
    return fits(link.name, glob) or any(_named((glob,), link, part) for part in link.parts)
