"""The pairs of links that do not collide, for people."""

from collections.abc import Mapping, Sequence
from typing import Any

from pipeline.page.markup import plain_table, section
from stages.robot.globs import listed


def contacts(excludes: Sequence[Mapping[str, Any]]) -> str:
    """The pairs of links that do not collide, those whose reason is not a joint first, and which of their
    colliders where others do."""
    order = sorted(excludes, key=lambda one: str(one["reason"]) == "Adjacent")
    rows = [[*one["links"], one["reason"], f"{one['depth']:.2f}", _only(one["colliders"])] for one in order]
    header = ["link", "other link", "reason", "depth at home, mm", "of their colliders"]
    return section("Links that do not collide", plain_table(header, rows), "contacts") if rows else ""


def _only(colliders: Sequence[Sequence[str]] | None) -> str:
    return "all" if colliders is None else " against ".join(map(listed, colliders))
