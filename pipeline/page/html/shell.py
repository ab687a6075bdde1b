"""A whole HTML document around the parts of a page, with its contents."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from linkwright.pipeline.page.html.markup import link, text

STYLE = Path(__file__).with_name("style.css")


@dataclass(frozen=True, slots=True)
class ReportSection:
    """A section of a page: what `#anchor` leads to, its short `title` for the contents, its HTML."""

    anchor: str
    title: str
    body: str


@dataclass(frozen=True, slots=True)
class Top:
    """What is above the contents: the `head`, with the heading, what the page shows, and `facts` about it."""

    head: str
    shown: str = ""
    facts: str = ""


def document(
    title: str, top: Top, parts: Sequence[ReportSection], foot: str, *, style: str = "", scripts: str = ""
) -> bytes:
    """The page: its top, the contents, the parts that have a body, and the `foot`; `title` is plain text.

    `style`, `scripts`: more CSS, and script elements for the end.
    """
    shown = [part for part in parts if part.body]
    body = "\n".join(part.body for part in shown)
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{text(title)}</title>\n"
        f"<style>\n{STYLE.read_text(encoding='utf-8')}{style}</style>\n"
        '</head>\n<body>\n<a class="skip" href="#report">Skip to the report</a>\n'
        f"<header>\n{top.head}\n</header>\n<main>\n{top.shown}\n{top.facts}\n"
        f'{contents(shown)}<div id="report" tabindex="-1">\n{body}\n</div>\n</main>\n'
        f"<footer>\n{foot}\n{scripts}</footer>\n</body>\n</html>\n"
    ).encode()


def contents(parts: Sequence[ReportSection]) -> str:
    """Links to the parts: a line on a wide screen, folded on a narrow one, none on paper."""
    named = [part for part in parts if part.title]
    if len(named) < 2:
        return ""
    items = "\n".join(f"<li>{link(f'#{part.anchor}', part.title)}</li>" for part in named)
    return (
        '<nav class="contents" aria-label="Contents">\n<details>\n<summary>Contents</summary>\n'
        f"<ul>\n{items}\n</ul>\n</details>\n</nav>\n"
    )
