"""Pieces of HTML: escaped text, tables that hold on a narrow screen, links and what is folded."""

import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any
from urllib.parse import quote

from linkwright.stages.robot.text.printable import printable_lines

DENSE = 8
"""Columns from which a table is set small."""

_LONG = re.compile(r"\S{17,}")
_JOINT = re.compile(r"([_/](?=[^_/])|\.(?=[A-Za-z]))")
_FIGURE = frozenset("0123456789.+-−≤≥")
"""What the text of a figure begins with."""
_SENTENCE = 4
"""Spaces that the text of a figure with its unit does not have."""


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
    return _breakable(text(value))


def _breakable(shown: str) -> str:
    """HTML without elements, with places where its long words may be broken."""
    if len(shown) < 17:
        return shown
    return _LONG.sub(lambda word: _JOINT.sub(r"\1<wbr>", word[0]), shown)


def shortened(words: str, most: int) -> str:
    """Plain text of at most so many letters, cut between words."""
    if len(words) <= most:
        return words
    return words[: most - 1].rpartition(" ")[0].rstrip(",;:") + " …"


def inline(markdown: str) -> str:
    """A line of Markdown: code and the words of links."""
    bare = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", markdown.replace("\\|", "|"))
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", text(bare))


def section(title: str, body: str, anchor: str) -> str:
    """A section with a heading, to which `#anchor` leads; nothing without a body."""
    return f'<section id="{anchor}">\n<h2>{title}</h2>\n{body}\n</section>' if body else ""


def part(title: str, body: str) -> str:
    """A part of a section with a heading; nothing without a body."""
    return f"<h3>{title}</h3>\n{body}" if body else ""


def folded(summary: str, body: str, *, on_paper: bool = True) -> str:
    """What opens on a click; nothing without a body. On paper it is open, or only its summary is there."""
    kind = "" if on_paper else ' class="brief"'
    return f"<details{kind}>\n<summary>{summary}</summary>\n{body}\n</details>" if body else ""


def table(
    header: Sequence[str],
    rows: Sequence[Sequence[str]],
    classes: Mapping[str, str] | None = None,
    heads: str = "",
) -> str:
    """A table of cells that are HTML already; columns without any text are left out, and so is a table
    without rows. `classes`: those of a column's cells, by its title; `heads`: the title of the column that
    names the rows. On a narrow screen a row becomes a block of lines, each with its column's title."""
    kept = [column for column in range(len(header)) if any(row[column] for row in rows)]
    if not kept:
        return ""
    titles = [text(header[column]) for column in kept]
    styles = [(classes or {}).get(header[column], "") for column in kept]
    heading = [bool(heads) and header[column] == heads for column in kept]
    opened = [_cell(*cell) for cell in zip(titles, styles, heading, strict=True)]
    closed = ["</th>" if one else "</td>" for one in heading]
    cells = list(zip(opened, closed, kept, strict=True))
    lines = [
        "<tr>" + "".join([f"{start}{row[column]}{end}" for start, end, column in cells]) + "</tr>"
        for row in rows
    ]
    columns = "".join(map(_title, titles, styles))
    head = f"<thead><tr>{columns}</tr></thead>\n" if any(titles) else ""
    body = "<tbody>\n" + "\n".join(lines) + "\n</tbody>\n"
    kind = "wide dense" if len(kept) >= DENSE else "wide"
    return f'<div class="{kind}"><table class="rows">\n{head}{body}</table></div>'


def _title(title: str, style: str) -> str:
    # Screen readers name a column that has no title, which only holds marks.
    if not title:
        return '<td class="word"></td>'
    figure = ' class="number"' if "number" in style else ""
    return f'<th scope="col"{figure}>{_breakable(title)}</th>'


def _cell(title: str, style: str, heads: bool) -> str:
    kind = f' class="{style}"' if style else ""
    label = f' data-label="{title}"' if title and not heads else ""
    return f'<th scope="row"{kind}>' if heads else f"<td{kind}{label}>"


def plain_table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """As `table`, of plain values; the first column names the rows, and figures stand below each other."""
    plain = list(rows)
    cells = [[name(value) for value in row] for row in plain]
    columns = range(len(header))
    classes = {header[column]: "number" for column in columns if _is_figures(row[column] for row in cells)}
    if header and classes.get(header[0]) == "number":
        return table(header, cells, classes)
    return table(header, cells, classes, heads=header[0] if header else "")


def _is_figures(cells: Iterable[str]) -> bool:
    """Whether each cell is empty or a figure with its unit, no sentence."""
    return all(not cell or (cell[0] in _FIGURE and cell.count(" ") < _SENTENCE) for cell in cells)


def pairs(values: Mapping[str, str]) -> str:
    """A table of names and what they are, which is HTML already; empty ones are left out."""
    rows = [
        f'<tr><th scope="row">{text(key)}</th><td>{value}</td></tr>' for key, value in values.items() if value
    ]
    lines = "\n".join(rows)
    whole = f'<div class="wide"><table class="pairs">\n<tbody>\n{lines}\n</tbody>\n</table></div>'
    return whole if rows else ""


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
