"""The kinematic graph: its picture, its outline as text, and the tables that the graph stage made of it."""

import re
from collections.abc import Mapping, Sequence
from html import unescape
from typing import Any

from markupsafe import Markup, escape

from linkwright.pipeline.page.html.tables import PageTable, plain_table
from linkwright.pipeline.page.html.template import file_link, rendered
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
    own = {title for titles in SECTIONS.values() for title in titles}
    others = [(one["title"], _plain(one)) for one in tables if one["title"] not in own]
    if not (svg or outline or any(it for _, it in others)):
        return ""
    drawn, width = _picture(svg, secrets)
    full = file_link(PICTURE) if is_file else ""
    return rendered("graph", picture=drawn, width=width, full=full, outline="\n".join(outline), others=others)


def tables_of(title: str, tables: Sequence[Table]) -> str:
    """A section of its own; nothing without its first table."""
    found = {one["title"]: _plain(one) for one in tables}
    first, *others = SECTIONS[title]
    parts = [(one, found.get(one)) for one in others]
    return rendered("tables", title=title, first=found[first], parts=parts) if found.get(first) else ""


def _plain(table: Table) -> PageTable | None:
    return plain_table(table["header"], table["rows"])


def _picture(svg: str, secrets: Secrets) -> tuple[Markup, str]:
    """The picture without its XML declaration, and its width; what it says is blanked, what it is made of is
    not."""
    bare = re.sub(r"^<\?xml.*?\?>\s*", "", svg)
    drawn = re.sub(r">([^<]+)<", lambda match: f">{escape(secrets.blanked(unescape(match[1])))}<", bare)
    wide = re.match(r'<svg [^>]*?width="(\d+)"', drawn)
    return Markup(drawn), wide[1] if wide else ""
