"""Makes the content of summary.csv: a row for each job of a sweep, by RFC 4180, for spreadsheets and
programs.

A spreadsheet runs a cell that begins with `=`, `+`, `-` or `@` as a formula. A text that begins with any of
these, or with an apostrophe, gets an apostrophe in front. A program that reads the file gets the text back by
removing an apostrophe at its beginning. Numbers are written unchanged.
"""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.figures import NAMES
from linkwright.pipeline.page.sweep.swept import keys
from linkwright.stages.robot.text.printable import printable_lines

FILE_NAME = "summary.csv"

JOB_COLUMNS = ("number", "label", "state", "status", "message", "folder")
RESULT_COLUMNS = ("objective", "checks_passed", "checks_failed", "checks_warned", "calls_made", "calls_saved")
"""The columns before the swept keys (`JOB_COLUMNS`), and after the figures (`RESULT_COLUMNS`)."""

KEY_PREFIX, FIGURE_PREFIX = "key.", "figure."
"""Prefixes of the columns of swept keys and of figures, so that no two columns have the same name."""

_ESCAPED_STARTS = tuple("=+-@'\t\r＝＋－＠")
"""First characters of texts that get an apostrophe, with the full-width forms of these signs."""


def csv_content(jobs: Sequence[Mapping[str, Any]]) -> bytes:
    """Returns the content of the file. `jobs`: the outcomes as plain data, with their `state` and without
    secrets."""
    swept_keys, figures = keys(jobs), figures_in(jobs)
    out = io.StringIO(newline="")
    writer = csv.writer(out)
    names = [
        *JOB_COLUMNS,
        *(KEY_PREFIX + key for key in swept_keys),
        *(FIGURE_PREFIX + name for name in figures),
        *RESULT_COLUMNS,
    ]
    writer.writerow([cell_text(name) for name in names])
    for job in jobs:
        checks = job["checks"]
        row = [
            *(job[name] for name in JOB_COLUMNS),
            *(job["overrides"].get(key, "") for key in swept_keys),
            *(job["figures"].get(name) for name in figures),
            job.get("objective"),
            *(checks.get("passed"), _count(checks.get("failed")), _count(checks.get("warned"))),
            *(job["calls"].get("made"), job["calls"].get("saved")),
        ]
        writer.writerow([cell_text(value) for value in row])
    return out.getvalue().encode()


def figures_in(jobs: Sequence[Mapping[str, Any]]) -> list[str]:
    """Returns the figures of any job: the usual figures in their order, then further figures by name."""
    names = {name for job in jobs for name in job["figures"]}
    return [name for name in NAMES if name in names] + sorted(names - NAMES.keys())


def cell_text(value: Any) -> str:
    """Returns the text of a cell: "" for None, a text escaped so that it is not a formula, any other value as
    JSON."""
    if value is None:
        return ""
    if not isinstance(value, str):
        encoded = json.dumps(value, ensure_ascii=False)
        return encoded if isinstance(value, int | float) else _escaped(encoded)
    return _escaped(value)


def _escaped(text: str) -> str:
    """Returns a text with an apostrophe in front if a spreadsheet could read it as a formula."""
    text = printable_lines(text)
    return f"'{text}" if text.lstrip(" \n").startswith(_ESCAPED_STARTS) else text


def _count(names: Sequence[str] | None) -> int | None:
    return None if names is None else len(names)
