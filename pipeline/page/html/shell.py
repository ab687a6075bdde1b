"""A whole HTML document around the parts of a page, with its contents."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from linkwright.pipeline.page.html.template import rendered

STYLE = Path(__file__).with_name("style.css")


@dataclass(frozen=True, slots=True)
class ReportSection:
    """A section of a page: what `#anchor` leads to, its short `title` for the contents, its HTML."""

    anchor: str
    title: str
    body: str


@dataclass(frozen=True, slots=True)
class Top:
    """What is above the contents: the `head`, with the heading, and `facts`, both HTML. The `picture` of the
    robot in base64, with the words `alt` for those who do not see it; it leads to a file `beside` the page
    where no view has it."""

    head: str
    facts: str = ""
    picture: str = ""
    alt: str = ""
    beside: str = ""


def document(
    title: str,
    top: Top,
    parts: Sequence[ReportSection],
    version: str = "",
) -> str:
    """The page: its top, the contents, and the parts that have a body, with places for the live view; `title`
    and `version` are plain text."""
    shown = [part for part in parts if part.body]
    style = Markup(STYLE.read_text(encoding="utf-8"))
    contents = [part for part in shown if part.title]
    whole = rendered(
        "document", title=title, style=style, top=top, contents=contents, parts=shown, version=version
    )
    return str(whole)
