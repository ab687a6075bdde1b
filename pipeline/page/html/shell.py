"""Renders a whole HTML document around the parts of a page, with a table of contents."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from linkwright.pipeline.page.html.template import rendered

STYLE = Path(__file__).with_name("style.css")


@dataclass(frozen=True, slots=True)
class ReportSection:
    """A section of a page."""

    anchor: str
    """The target of links to the section, without `#`."""
    title: str
    """The short title for the table of contents."""
    body: str
    """The HTML of the section; "" if it is left out."""


@dataclass(frozen=True, slots=True)
class Top:
    """The part of a page above its table of contents."""

    head: str
    """HTML with the heading."""
    facts: str = ""
    """HTML with figures and files."""
    picture: str = ""
    """The picture of the robot in base64."""
    alt: str = ""
    """The text of the picture for readers who do not see it."""
    beside: str = ""
    """The file beside the page to which the picture links if there is no live view."""


def document(
    title: str,
    top: Top,
    parts: Sequence[ReportSection],
    version: str = "",
) -> str:
    """Renders the page: its top, the contents, and the parts that have a body, with placeholders for the live
    view. `title` and `version` are plain text."""
    filled_parts = [part for part in parts if part.body]
    style = Markup(STYLE.read_text(encoding="utf-8"))
    contents = [part for part in filled_parts if part.title]
    html = rendered(
        "document", title=title, style=style, top=top, contents=contents, parts=filled_parts, version=version
    )
    return str(html)
