"""The pairs of links that do not collide: those that the configuration names, and those that colliders by
contact need not keep apart."""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from linkwright.stages.mesh.contacts.by_source import excluded
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.adjacency import Pair, adjacent_pairs
from linkwright.stages.robot.text.globs import fits, there_are

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import ContactSection


def apart(
    robot: Robot, solid: Collection[str], keys: "ContactSection", chosen: Collection[Pair]
) -> set[Pair] | None:
    """The pairs of `solid` links that do not collide: those next to each other, those that the configuration
    (`chosen`) or the source excludes. None where no two links collide."""
    if keys.self_ == "none":
        return None
    found = {*chosen, *adjacent_pairs(robot, solid)}
    if keys.self_ == "auto":
        found |= {(one.link_a, one.link_b) for one in robot.semantics.disabled if one.touches}
        found |= {(one, other) for one, other in map(sorted, excluded(robot))}
    return found


_WHERE = "contact.exclude"


def chosen_pairs(
    links: Sequence[str], wanted: Sequence[tuple[str, str]], log: Diagnostics
) -> frozenset[Pair]:
    """The pairs of `links` that some pair of globs matches, either way round; each in the order of `links`.

    E-GLOB for each glob that matches no link, and for each pair of globs that matches no two different links.
    """
    place = {link: index for index, link in enumerate(links)}
    found: set[Pair] = set()
    missing: set[str] = set()
    for globs in wanted:
        sides = [[link for link in links if fits(link, glob)] for glob in globs]
        for glob in (glob for glob, side in zip(globs, sides, strict=True) if not side):
            if glob not in missing:
                hint = there_are(glob, {"links": links})
                log.unmatched("E-GLOB", f"no link matches {glob!r}", _WHERE, hint, glob)
            missing.add(glob)
        pairs = {(a, b) if place[a] < place[b] else (b, a) for a in sides[0] for b in sides[1] if a != b}
        if all(sides) and not pairs:
            text = f"{globs[0]!r} and {globs[1]!r} match the same link, which cannot touch itself"
            log.report("E-GLOB", text, _WHERE, there_are("", {"links": links}))
        found |= pairs
    return frozenset(found)
