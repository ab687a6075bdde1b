"""The pairs of links that do not collide, for people."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.html.tables import PageTable, plain_table
from linkwright.pipeline.page.html.template import rendered
from linkwright.stages.robot.text.globs import listed
from linkwright.stages.robot.text.plural import count


def contacts(excludes: Sequence[Mapping[str, Any]]) -> str:
    """The section: the pairs with their reason, and which of their colliders where others do; those with a
    joint between them are folded."""
    near = [one for one in excludes if str(one["reason"]) == "Adjacent"]
    others = [one for one in excludes if str(one["reason"]) != "Adjacent"]
    words = f"{count(len(near), 'pair')} with a joint between them"
    values = {"others": _table(others), "words": words, "near": _table(near)}
    return rendered("contacts", **values) if excludes else ""


def _table(excludes: Sequence[Mapping[str, Any]]) -> PageTable | None:
    rows = [
        [*one["links"], one["reason"], f"{one['depth']:.2f}", _only(one["colliders"])] for one in excludes
    ]
    return plain_table(["link", "other link", "reason", "depth at home, mm", "of their colliders"], rows)


def _only(colliders: Sequence[Sequence[str]] | None) -> str:
    return "all" if colliders is None else " against ".join(map(listed, colliders))
