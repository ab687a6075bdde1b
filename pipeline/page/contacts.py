"""Renders the pairs of links that do not collide."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.html.tables import PageTable, plain_table
from linkwright.pipeline.page.html.template import rendered
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.robot.text.plural import count


def excluded_pairs_section(excludes: Sequence[Mapping[str, Any]]) -> str:
    """Renders a table of the excluded pairs, with reason, depth and colliders. Pairs with a joint between
    them are in a second table, which is folded."""
    if not excludes:
        return ""
    adjacent = [row for row in excludes if str(row["reason"]) == "Adjacent"]
    other_pairs = [row for row in excludes if str(row["reason"]) != "Adjacent"]
    fold_title = f"{count(len(adjacent), 'pair')} with a joint between them"
    tables = {"other_pairs": _table(other_pairs), "adjacent": _table(adjacent)}
    return rendered("contacts", **tables, fold_title=fold_title)


def _table(excludes: Sequence[Mapping[str, Any]]) -> PageTable | None:
    rows = [
        [*row["links"], row["reason"], f"{row['depth']:.2f}", _colliders_text(row["colliders"])]
        for row in excludes
    ]
    return plain_table(["link", "other link", "reason", "depth at home, mm", "colliders concerned"], rows)


def _colliders_text(colliders: Sequence[Sequence[str]] | None) -> str:
    """Returns the text of the excluded colliders of both links. `colliders`: the names of each link's
    colliders; None for all."""
    return "all" if colliders is None else " against ".join(map(name_list, colliders))
