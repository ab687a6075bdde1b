"""Reads the table of the options of other tools, and what they are called here."""

from pathlib import Path
from typing import NamedTuple

import yaml


class PeerRow(NamedTuple):
    """A row of PEERS.md.

    theirs: the names that the row stands for.
    yaml: what a robot's file says in their place.
    command: what follows `linkwright`.
    python: what is written with `import linkwright`.
    note: what differs. A row without the three above is about names that have no counterpart here, and the
        note says why.
    """

    theirs: tuple[str, ...]
    yaml: str = ""
    command: str = ""
    python: str = ""
    note: str = ""


_DATA = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))

TABLES = {
    title: tuple(PeerRow(**{**row, "theirs": tuple(row["theirs"])}) for row in rows)
    for title, rows in _DATA.items()
}
"""Title of a table → its rows."""

ONSHAPE_TO_ROBOT = {name: row for row in TABLES["onshape-to-robot"] for name in row.theirs}
"""Option of onshape-to-robot → its row."""
