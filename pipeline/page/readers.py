"""What other readers drop of the robot's files, for people."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.html.tables import table
from linkwright.pipeline.page.html.template import inline, name, rendered
from linkwright.stages.robot.text.plural import count

SHOWN = 6
"""Of what a row is about so many names are shown; report.json has all."""


def readers(rows: Sequence[Mapping[str, Any]]) -> str:
    """The section; nothing without rows. `rows`: `readers` of the report's details."""
    header = ["reader", "version", "format", "what", "does with it", "of", "source"]
    keys = ("reader", "version", "format", "thing", "does")
    cells = [
        [*(inline(row[key]) for key in keys), name(_some(row["of"])), inline(row["source"])] for row in rows
    ]
    words = f"{count(len({row['reader'] for row in rows}), 'reader')}, {count(len(rows), 'thing')}"
    return rendered("readers", words=words, table=table(header, cells, heads="reader")) if rows else ""


def _some(names: Sequence[str]) -> str:
    more = len(names) - SHOWN
    return ", ".join(names[:SHOWN]) + (f" and {more} more" if more > 0 else "")
