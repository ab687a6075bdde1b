"""Renders the pairs of links that do not collide."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.html.tables import PageTable, plain_table
from linkwright.pipeline.page.html.template import rendered
from linkwright.stages.robot.text.globs import listed
from linkwright.stages.robot.text.plural import count


def contacts(excludes: Sequence[Mapping[str, Any]]) -> str:
    """Renders the section: each pair with its reason, and with its colliders if only some of them do not
    collide. Pairs with a joint between them are folded."""
    adjacent = [row for row in excludes if str(row["reason"]) == "Adjacent"]
    other_pairs = [row for row in excludes if str(row["reason"]) != "Adjacent"]
    words = f"{count(len(adjacent), 'pair')} with a joint between them"
    values = {"distant": _table(other_pairs), "words": words, "near": _table(adjacent)}
    return rendered("contacts", **values) if excludes else ""


def _table(excludes: Sequence[Mapping[str, Any]]) -> PageTable | None:
    rows = [
        [*row["links"], row["reason"], f"{row['depth']:.2f}", _colliders(row["colliders"])]
        for row in excludes
    ]
    return plain_table(["link", "other link", "reason", "depth at home, mm", "of their colliders"], rows)


def _colliders(colliders: Sequence[Sequence[str]] | None) -> str:
    return "all" if colliders is None else " against ".join(map(listed, colliders))
