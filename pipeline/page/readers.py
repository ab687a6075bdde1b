"""What other readers drop of the robot's files, for people."""

from collections.abc import Mapping, Sequence
from typing import Any

from pipeline.page.markup import plain_table, section

SHOWN = 6
"""Of what a row is about so many names are shown; report.json has all."""


def readers(rows: Sequence[Mapping[str, Any]]) -> str:
    """The section; nothing without rows. `rows`: `readers` of the report's details."""
    header = ["reader", "version", "format", "what", "does with it", "of", "source"]
    keys = ("reader", "version", "format", "thing", "does")
    cells = [[*(row[key] for key in keys), _some(row["of"]), row["source"]] for row in rows]
    return section("What other readers drop", plain_table(header, cells), "readers") if cells else ""


def _some(names: Sequence[str]) -> str:
    more = len(names) - SHOWN
    return ", ".join(names[:SHOWN]) + (f" and {more} more" if more > 0 else "")
