"""Renders which content of the robot's files other readers drop."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.html.tables import table
from linkwright.pipeline.page.html.template import inline, name, rendered
from linkwright.stages.robot.text.plural import count

MAX_NAMES = 6
"""Largest number of names in a row; report.json has all."""


def readers(rows: Sequence[Mapping[str, Any]]) -> str:
    """Renders the section; "" without rows. `rows`: `readers` of the report's details."""
    header = ["reader", "version", "format", "what", "does with it", "of", "as a target", "source"]
    keys = ("reader", "version", "format", "thing", "does")
    cells = [
        [
            *(inline(row[key]) for key in keys),
            name(_first_names(row["of"])),
            inline(row.get("target", "")),
            inline(row["source"]),
        ]
        for row in rows
    ]
    words = f"{count(len({row['reader'] for row in rows}), 'reader')}, {count(len(rows), 'thing')}"
    return rendered("readers", words=words, table=table(header, cells, heads="reader")) if rows else ""


def _first_names(names: Sequence[str]) -> str:
    rest = len(names) - MAX_NAMES
    return ", ".join(names[:MAX_NAMES]) + (f" and {rest} more" if rest > 0 else "")
