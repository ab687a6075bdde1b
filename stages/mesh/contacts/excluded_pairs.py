"""Collects the pairs of links that do not collide: pairs that the configuration names, and all pairs that
colliders by contact need not keep apart."""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from linkwright.stages.mesh.contacts.by_source import excluded_by_source
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.adjacency import Pair, adjacent_pairs
from linkwright.stages.robot.text.globs import matches_glob, no_match_hint

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import ContactSection


def excluded_pairs(
    robot: Robot, solid: Collection[str], keys: "ContactSection", chosen: Collection[Pair]
) -> set[Pair] | None:
    """Returns the pairs of `solid` links that do not collide: neighbours, and pairs that the configuration
    (`chosen`) or the source excludes. None if no two links collide."""
    if keys.self_ == "none":
        return None
    pairs = {*chosen, *adjacent_pairs(robot, solid)}
    if keys.self_ == "auto":
        pairs |= {(pair.link_a, pair.link_b) for pair in robot.semantics.disabled if pair.touches}
        pairs |= {(first, second) for first, second in map(sorted, excluded_by_source(robot))}
    return pairs


_EXCLUDE_KEY = "contact.exclude"


def chosen_pairs(
    links: Sequence[str], glob_pairs: Sequence[tuple[str, str]], log: Diagnostics
) -> frozenset[Pair]:
    """Returns the pairs of `links` that a pair of globs matches in either order; the links of a pair are in
    the order of `links`.

    Reports E-GLOB for each glob that matches no link, and for each pair of globs that does not match two
    different links.
    """
    position = {link: index for index, link in enumerate(links)}
    matching_pairs: set[Pair] = set()
    reported_globs: set[str] = set()
    for globs in glob_pairs:
        sides = [[link for link in links if matches_glob(link, glob)] for glob in globs]
        for glob in (glob for glob, side in zip(globs, sides, strict=True) if not side):
            if glob not in reported_globs:
                hint = no_match_hint(glob, {"links": links})
                log.report_unmatched("E-GLOB", f"no link matches {glob!r}", _EXCLUDE_KEY, hint, glob)
            reported_globs.add(glob)
        pairs = {
            (a, b) if position[a] < position[b] else (b, a) for a in sides[0] for b in sides[1] if a != b
        }
        if all(sides) and not pairs:
            text = f"{globs[0]!r} and {globs[1]!r} match the same link, which cannot touch itself"
            log.report("E-GLOB", text, _EXCLUDE_KEY, no_match_hint("", {"links": links}))
        matching_pairs |= pairs
    return frozenset(matching_pairs)
