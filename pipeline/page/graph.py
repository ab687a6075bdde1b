"""Renders the kinematic graph: its picture, its outline as text, and its tables."""

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
"""Title of a section → titles of its tables, the first directly under the section's heading. All other tables
belong to the graph's section."""


def graph(
    svg: str, outline: Sequence[str], tables: Sequence[Table], secrets: Secrets, *, is_file: bool
) -> str:
    """Renders the section; "" without a graph. `is_file`: whether the picture is also a file beside the
    page."""
    other_titles = {title for titles in SECTIONS.values() for title in titles}
    parts = [(table["title"], _page_table(table)) for table in tables if table["title"] not in other_titles]
    if not (svg or outline or any(part for _, part in parts)):
        return ""
    picture, width = _picture(svg, secrets)
    full = file_link(PICTURE) if is_file else ""
    return rendered("graph", picture=picture, width=width, full=full, outline="\n".join(outline), parts=parts)


def tables_of(title: str, tables: Sequence[Table]) -> str:
    """Renders one of `SECTIONS`; "" without its first table."""
    page_tables = {table["title"]: _page_table(table) for table in tables}
    first, *other_titles = SECTIONS[title]
    parts = [(name, page_tables.get(name)) for name in other_titles]
    return (
        rendered("tables", title=title, first=page_tables[first], parts=parts)
        if page_tables.get(first)
        else ""
    )


def _page_table(table: Table) -> PageTable | None:
    return plain_table(table["header"], table["rows"])


def _picture(svg: str, secrets: Secrets) -> tuple[Markup, str]:
    """Returns the picture without its XML declaration, and its width; secrets are blanked in its texts
    only."""
    svg_element = re.sub(r"^<\?xml.*?\?>\s*", "", svg)
    picture = re.sub(
        r">([^<]+)<", lambda match: f">{escape(secrets.blanked(unescape(match[1])))}<", svg_element
    )
    size = re.match(r'<svg [^>]*?width="(\d+)"', picture)
    return Markup(picture), size[1] if size else ""
