"""What the verbs of the original Robot class, and the options of onshape-to-robot, are called here.

The rows of `pipeline/reference/PEERS.md` are in peers.yaml, each with the YAML or the command that
test_peers.py runs.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import yaml


class Row(NamedTuple):
    """`theirs`: names that the row stands for; `yaml`: in a robot's file; `command`: after `linkwright`;
    `python`: with `import linkwright`; `note`: what differs. None of the three: there is no such thing here,
    and the note says why."""

    theirs: tuple[str, ...]
    yaml: str = ""
    command: str = ""
    python: str = ""
    note: str = ""


_DATA = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))

TITLES = {
    title: tuple(Row(**{**row, "theirs": tuple(row["theirs"])}) for row in rows)
    for title, rows in _DATA.items()
}
"""Title of a table → its rows."""

ROBOT_CLASS, ONSHAPE_TO_ROBOT = TITLES.values()

INTRODUCTION = """\
# Coming from another tool

Generated from `tests/config/peers.yaml` by `python -m tests.config.regenerate`; do not edit. YAML belongs
into a robot's file (`robot/my_arm.yaml`), a line that begins with `linkwright` into the terminal. A test runs
every row.
"""


HEAD = "| there | here | |\n| --- | --- | --- |\n"
"""How a table of rows begins."""

TOOLKIT_PAGE = Path(__file__).resolve().parents[2] / "docs" / "start" / "robotics-toolkit.md"
"""The page of the documents that ends with the rows of the original Robot class."""


def markdown() -> str:
    """The page."""
    return "\n".join([INTRODUCTION, *(f"## {title}\n\n{table(rows)}" for title, rows in TITLES.items())])


def toolkit_page() -> str:
    """TOOLKIT_PAGE, with its last table made anew."""
    text, _, _ = TOOLKIT_PAGE.read_text(encoding="utf-8").partition(HEAD)
    return text + table(ROBOT_CLASS)


def table(rows: Sequence[Row]) -> str:
    """Rows as a table in Markdown."""
    lines = (
        f"| {', '.join(f'`{name}`' for name in row.theirs)} | {_ours(row)} | {row.note} |\n" for row in rows
    )
    return HEAD + "".join(lines)


def _ours(row: Row) -> str:
    code = row.yaml or row.python or (f"linkwright {row.command}" if row.command else "")
    return f"`{code}`" if code else "-"
