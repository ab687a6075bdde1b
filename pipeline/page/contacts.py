"""The pairs of links that do not collide, for people."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.html.markup import folded, plain_table, section
from linkwright.stages.robot.text.globs import listed
from linkwright.stages.robot.text.plural import count


def contacts(excludes: Sequence[Mapping[str, Any]]) -> str:
    """The section: the pairs with their reason, and which of their colliders where others do; those with a
    joint between them are folded."""
    near = [one for one in excludes if str(one["reason"]) == "Adjacent"]
    others = [one for one in excludes if str(one["reason"]) != "Adjacent"]
    joined = folded(f"{count(len(near), 'pair')} with a joint between them", _table(near))
    return section("Links that do not collide", _table(others) + joined, "contacts")


def _table(excludes: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        [*one["links"], one["reason"], f"{one['depth']:.2f}", _only(one["colliders"])] for one in excludes
    ]
    return plain_table(["link", "other link", "reason", "depth at home, mm", "of their colliders"], rows)


def _only(colliders: Sequence[Sequence[str]] | None) -> str:
    return "all" if colliders is None else " against ".join(map(listed, colliders))
