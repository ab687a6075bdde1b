"""Prepares the tables of a page: their columns and cells."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from linkwright.pipeline.page.html.template import name, text

MIN_DENSE_COLUMNS = 8
"""Least number of columns of a table in small type."""

_FIGURE_STARTS = frozenset("0123456789.+-−≤≥")
"""Characters with which a figure can begin."""

_MIN_SENTENCE_SPACES = 4
"""Least number of spaces in a sentence; a figure with its unit has fewer."""


@dataclass(frozen=True, slots=True)
class Column:
    """The `title` of a column, the `style` of its cells, and whether they head the rows."""

    title: str
    style: str
    heads: bool


@dataclass(frozen=True, slots=True)
class PageTable:
    """A table of a page: its columns, and the cells of each row."""

    columns: Sequence[Column]
    rows: Sequence[Sequence[Any]]

    @property
    def titled(self) -> bool:
        return any(column.title for column in self.columns)

    @property
    def kind(self) -> str:
        return "wide dense" if len(self.columns) >= MIN_DENSE_COLUMNS else "wide"


def table(
    header: Sequence[str],
    rows: Sequence[Sequence[Any]],
    classes: Mapping[str, str] | None = None,
    heads: str = "",
) -> PageTable | None:
    """Returns a table of texts and HTML without its empty columns; None if nothing remains.

    `classes`: title of a column → class of its cells; `heads`: title of the column that names the rows.
    """
    filled_columns = [index for index in range(len(header)) if any(text(row[index]) for row in rows)]
    columns = [
        Column(header[index], (classes or {}).get(header[index], ""), bool(heads) and header[index] == heads)
        for index in filled_columns
    ]
    return (
        PageTable(columns, [[row[index] for index in filled_columns] for row in rows])
        if filled_columns
        else None
    )


def plain_table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> PageTable | None:
    """Returns a table of plain values. The first column names the rows; columns of figures are
    right-aligned."""
    cells = [[name(value) for value in row] for row in rows]
    columns = range(len(header))
    classes = {header[column]: "number" for column in columns if _is_figures(row[column] for row in cells)}
    heads = header[0] if header and classes.get(header[0]) != "number" else ""
    return table(header, cells, classes, heads)


def _is_figures(cells: Iterable[str]) -> bool:
    """Tells whether each cell is empty or a figure with its unit, and not a sentence."""
    return all(
        not cell or (cell[0] in _FIGURE_STARTS and cell.count(" ") < _MIN_SENTENCE_SPACES) for cell in cells
    )


def plain_pairs(values: Mapping[str, Any]) -> dict[str, Any]:
    """Returns values by name, with spaces in place of underscores; empty values are left out."""
    return {key.replace("_", " "): value for key, value in values.items() if text(value)}
