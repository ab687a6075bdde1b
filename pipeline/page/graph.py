"""The kinematic graph: its picture, its outline as text, and the tables that the graph stage made of it."""

import re
from collections.abc import Mapping, Sequence
from html import escape, unescape
from typing import Any

from linkwright.pipeline.page.html.markup import file_link, folded, part, plain_table, section, text
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.show.graph_view.views import PICTURE

Table = Mapping[str, Any]
"""A table of the graph stage: title, header, rows."""

SECTIONS = {"Joints": ("Joints", "Dynamics"), "Masses": ("Masses",)}
"""Sections of their own, and the tables in each, the first under the section's heading; others are parts of
the graph's."""


def graph(
    svg: str, outline: Sequence[str], tables: Sequence[Table], secrets: Secrets, *, is_file: bool
) -> str:
    """The section; nothing without a graph. `is_file`: whether the picture is a file beside the page."""
    others = [
        part(text(one["title"]), plain_table(one["header"], one["rows"]))
        for one in tables
        if not any(one["title"] in titles for titles in SECTIONS.values())
    ]
    body = [_picture(svg, secrets, is_file), _outline(outline), *others]
    return section("Kinematic graph", "\n".join(filter(None, body)), "graph")


def tables_of(title: str, tables: Sequence[Table]) -> str:
    """A section of its own; nothing without its first table."""
    found = {one["title"]: plain_table(one["header"], one["rows"]) for one in tables}
    first, *others = SECTIONS[title]
    if first not in found:
        return ""
    parts = [part(text(one), found.get(one, "")) for one in others]
    return section(text(title), "\n".join(filter(None, [found[first], *parts])), title.lower())


def _picture(svg: str, secrets: Secrets, is_file: bool) -> str:
    """The picture without its XML declaration; what it says is blanked, what it is made of is not."""
    if not svg:
        return ""
    bare = re.sub(r"^<\?xml.*?\?>\s*", "", svg)
    drawn = re.sub(r">([^<]+)<", lambda match: f">{escape(secrets.blanked(unescape(match[1])))}<", bare)
    full = f'\n<p class="soft screen">in full: {file_link(PICTURE)}</p>' if is_file else ""
    wide = re.match(r'<svg [^>]*?width="(\d+)"', drawn)
    # So that its words stay legible, it scrolls where it is wider than the page.
    style = f' style="--wide: {wide[1]}px"' if wide else ""
    return f'<div class="picture"{style}>{drawn}</div>{full}'


def _outline(lines: Sequence[str]) -> str:
    whole = "\n".join(lines)
    return folded("The tree as text", f"<pre>{text(whole)}</pre>") if whole else ""
