"""Tables of a page: their columns and cells, ready to be shown."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from linkwright.pipeline.page.html.template import name, text

DENSE = 8
"""Columns from which a table is set small."""

_FIGURE = frozenset("0123456789.+-−≤≥")
"""What the text of a figure begins with."""

_SENTENCE = 4
"""Spaces that the text of a figure with its unit does not have."""


@dataclass(frozen=True, slots=True)
class Column:
    """The `title` of a column, the `style` of its cells, and whether they head the rows."""

    title: str
    style: str
    heads: bool


@dataclass(frozen=True, slots=True)
class PageTable:
    """The columns, and the cells of each row."""

    columns: Sequence[Column]
    rows: Sequence[Sequence[Any]]

    @property
    def titled(self) -> bool:
        return any(column.title for column in self.columns)

    @property
    def kind(self) -> str:
        return "wide dense" if len(self.columns) >= DENSE else "wide"


def table(
    header: Sequence[str],
    rows: Sequence[Sequence[Any]],
    classes: Mapping[str, str] | None = None,
    heads: str = "",
) -> PageTable | None:
    """A table of texts and HTML; columns without any text are left out, and so is a table without rows.

    `classes`: those of a column's cells, by its title; `heads`: the title of the column that names the rows.
    """
    kept = [at for at in range(len(header)) if any(text(row[at]) for row in rows)]
    columns = [
        Column(header[at], (classes or {}).get(header[at], ""), bool(heads) and header[at] == heads)
        for at in kept
    ]
    return PageTable(columns, [[row[at] for at in kept] for row in rows]) if kept else None


def plain_table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> PageTable | None:
    """As `table`, of plain values; the first column names the rows, and figures stand below each other."""
    cells = [[name(value) for value in row] for row in rows]
    columns = range(len(header))
    classes = {header[column]: "number" for column in columns if _is_figures(row[column] for row in cells)}
    heads = header[0] if header and classes.get(header[0]) != "number" else ""
    return table(header, cells, classes, heads)


def _is_figures(cells: Iterable[str]) -> bool:
    """Whether each cell is empty or a figure with its unit, no sentence."""
    return all(not cell or (cell[0] in _FIGURE and cell.count(" ") < _SENTENCE) for cell in cells)


def plain_pairs(values: Mapping[str, Any]) -> dict[str, Any]:
    """Names without underscores and what they are, without those that are nothing."""
    return {key.replace("_", " "): value for key, value in values.items() if text(value)}
