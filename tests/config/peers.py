"""What the verbs of the original Robot class, and the options of onshape-to-robot, are called here.

The rows of `pipeline/reference/PEERS.md` are in `pipeline/reference/peers.yaml`, each with the YAML or the
command that test_peers.py runs; `linkwright new --from` takes its reasons from them.
"""

from pathlib import Path

from linkwright.pipeline.reference.peers import TABLES

ROBOT_CLASS, ONSHAPE_TO_ROBOT = TABLES.values()

INTRODUCTION = """\
# Coming from another tool

Generated from `pipeline/reference/peers.yaml` by `python -m tests.config.regenerate`; do not edit. YAML
belongs into a robot's file (`robot/my_arm.yaml`), a line that begins with `linkwright` into the terminal. A
test runs every row.
"""


HEAD = "| there | here | |\n| --- | --- | --- |\n"
"""How a table of rows begins."""

TOOLKIT_PAGE = Path(__file__).resolve().parents[2] / "docs" / "start" / "robotics-toolkit.md"
"""The page of the documents that ends with the rows of the original Robot class."""


def markdown():
    """The page."""
    return "\n".join([INTRODUCTION, *(f"## {title}\n\n{table(rows)}" for title, rows in TABLES.items())])


def toolkit_page():
    """TOOLKIT_PAGE, with its last table made anew."""
    text, _, _ = TOOLKIT_PAGE.read_text(encoding="utf-8").partition(HEAD)
    return text + table(ROBOT_CLASS)


def table(rows):
    """Rows as a table in Markdown."""
    lines = (
        f"| {', '.join(f'`{name}`' for name in row.theirs)} | {_ours(row)} | {row.note} |\n" for row in rows
    )
    return HEAD + "".join(lines)


def _ours(row):
    code = row.yaml or row.python or (f"linkwright {row.command}" if row.command else "")
    return f"`{code}`" if code else "-"
