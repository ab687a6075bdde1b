"""Pieces of HTML: escaped text, tables that hold on a narrow screen, links and what is folded."""

import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any
from urllib.parse import quote

from stages.robot.printable import printable_lines

DENSE = 8
"""Columns from which a table is set small."""

_LONG = re.compile(r"\S{17,}")


def text(value: Any) -> str:
    """A value as people read it, escaped."""
    if value is None:
        return ""
    if isinstance(value, Mapping):
        return ", ".join(f"{text(key)}: {text(item)}" for key, item in value.items())
    plain = f"{value:.6g}" if isinstance(value, float) else str(value)
    return escape(printable_lines(plain))


def name(value: Any) -> str:
    """As `text`, of a name or a path: a long one may be broken where its words are joined."""
    return _LONG.sub(lambda word: re.sub(r"([_/])(?=[^_/])", r"\1<wbr>", word[0]), text(value))


def section(title: str, body: str) -> str:
    """A section with a heading; nothing without a body."""
    return f"<section>\n<h2>{title}</h2>\n{body}\n</section>" if body else ""


def folded(summary: str, body: str) -> str:
    """What opens on a click; nothing without a body."""
    return f"<details>\n<summary>{summary}</summary>\n{body}\n</details>" if body else ""


def table(
    header: Sequence[str], rows: Sequence[Sequence[str]], classes: Mapping[str, str] | None = None
) -> str:
    """A table of cells that are HTML already; columns without any text are left out, and so is a table
    without rows. `classes`: those of a column's cells, by its title. On a narrow screen a row becomes a
    block of lines, each with its column's title."""
    kept = [column for column in range(len(header)) if any(row[column] for row in rows)]
    if not kept:
        return ""
    titles = [text(header[column]) for column in kept]
    styles = [(classes or {}).get(header[column], "") for column in kept]
    opened = [_cell(title, style) for title, style in zip(titles, styles, strict=True)]
    lines = [
        "<tr>"
        + "".join(f"{tag}{row[column]}</td>" for tag, column in zip(opened, kept, strict=True))
        + "</tr>"
        for row in rows
    ]
    head = "<thead><tr>" + "".join(f"<th>{title}</th>" for title in titles) + "</tr></thead>\n"
    body = "<tbody>\n" + "\n".join(lines) + "\n</tbody>\n"
    kind = "wide dense" if len(kept) >= DENSE else "wide"
    return f'<div class="{kind}"><table class="rows">\n{head if any(titles) else ""}{body}</table></div>'


def _cell(title: str, style: str) -> str:
    label = f' data-label="{title}"' if title else ""
    return f'<td class="{style}"{label}>' if style else f"<td{label}>"


def plain_table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """As `table`, of plain values."""
    return table(header, [[name(value) for value in row] for row in rows])


def pairs(values: Mapping[str, str]) -> str:
    """A table of names and what they are, which is HTML already; empty ones are left out."""
    rows = [f"<tr><th>{text(key)}</th><td>{value}</td></tr>" for key, value in values.items() if value]
    return '<table class="pairs">\n' + "\n".join(rows) + "\n</table>" if rows else ""


def plain_pairs(values: Mapping[str, Any]) -> str:
    """As `pairs`, of plain values, the names without underscores."""
    return pairs({key.replace("_", " "): text(value) for key, value in values.items()})


def image(png: str, words: str, width: int, height: int) -> str:
    """A picture that is part of the page: a PNG in base64; `words` for those who do not see it."""
    return f'<img src="data:image/png;base64,{png}" alt="{text(words)}" width="{width}" height="{height}">'


def link(target: str, words: str) -> str:
    """A link to a web page, or to a place of this one (`#...`)."""
    return f'<a href="{text(target)}">{text(words)}</a>'


def file_link(path: str) -> str:
    """A link to a file beside the page."""
    return f'<a href="{quote(path)}">{text(path)}</a>'
