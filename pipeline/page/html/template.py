"""Fills the templates of the pages, and renders pieces within a line: escaped, as `Markup`."""

import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

from markupsafe import Markup, escape

from linkwright.stages.formats.templates import Templates
from linkwright.stages.robot.text.printable import printable_lines

_LONG_WORD = re.compile(r"\S{17,}")
"""A word that may need a line break, which `<wbr>` allows at each `_BREAK_PLACE`."""
_BREAK_PLACE = re.compile(r"([_/](?=[^_/])|\.(?=[A-Za-z]))")


def rendered(name: str, /, **values: Any) -> Markup:
    """Fills the template of this name with values."""
    return Markup(_templates().filled(f"{name}.html", **values))


@cache
def _templates() -> Templates:
    filters: dict[str, Callable[..., Any]] = {
        "name": name,
        "inline": inline,
        "quote": quote,
        "tenths": "{:.1f}".format,
    }
    return Templates(Path(__file__).with_name("templates"), filters, text)


def text(value: Any) -> str:
    """Returns a value as text for people; HTML stays as it is."""
    if value is None:
        return ""
    if isinstance(value, Markup):
        return value
    if isinstance(value, Mapping):
        return ", ".join(f"{text(key)}: {text(item)}" for key, item in value.items())
    return printable_lines(f"{value:.6g}" if isinstance(value, float) else str(value))


def name(value: Any) -> Markup:
    """Returns a name or a path as text; a long name may be broken between its words."""
    escaped = str(escape(text(value)))
    if len(escaped) < 17:
        return Markup(escaped)
    return Markup(_LONG_WORD.sub(lambda word: _BREAK_PLACE.sub(r"\1<wbr>", word[0]), escaped))


def shortened(words: str, max_letters: int) -> str:
    """Shortens plain text to at most `max_letters` letters, between words."""
    if len(words) <= max_letters:
        return words
    return words[: max_letters - 1].rpartition(" ")[0].rstrip(",;:") + " …"


def inline(markdown: str) -> Markup:
    """Converts a line of Markdown to HTML: code stays code, and a link becomes its text."""
    bare = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", markdown.replace("\\|", "|"))
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text(bare)))))


def marked(kind: str, words: Any) -> Markup:
    """Returns words with a class of the style, `kind`; "" without words."""
    return Markup('<span class="{}">{}</span>').format(kind, text(words)) if words else Markup("")


def stacked(lines: Iterable[Any]) -> Markup:
    """Returns lines below each other."""
    return Markup("<br>").join(text(line) for line in lines)


def hint(words: Any) -> Markup:
    """Returns a hint on a line of its own; "" without words."""
    return marked("hint", Markup("→ {}").format(text(words))) if words else Markup("")


def link(target: str, words: Any) -> Markup:
    """Returns a link to a web page, or to an anchor of this page (`#...`)."""
    return Markup('<a href="{}">{}</a>').format(text(target), text(words))


def file_link(path: str) -> Markup:
    """Returns a link to a file beside the page."""
    return link(quote(path), path)
