"""Writes the jobs of a sweep for the script of the page: a block of JSON, by column.

Texts that many jobs share are listed once, and numbers have nine digits: ten thousand jobs stay below 5 MB.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.figures import name_of
from linkwright.pipeline.page.sweep.swept import Job, figures_of, places
from linkwright.stages.robot.text.printable import printable_lines

STATES = ("built", "unmet", "failed", "running", "missing")

PREVIEW, REPORT, FOLDER = 1, 2, 4
"""Bits that say which of a job's picture, page and folder exist."""

PREVIEW_FILE, REPORT_FILE = "preview.png", "report.html"

_DIGITS = 9


def existence_bits(job: Job, exists: Callable[[str], bool]) -> int:
    """Returns the bits of a job: which of its picture, page and folder exist."""
    folder = job["folder"]
    if job["state"] == "missing" or not exists(folder):
        return 0
    files = ((PREVIEW, PREVIEW_FILE), (REPORT, REPORT_FILE))
    return FOLDER + sum(bit for bit, name in files if exists(f"{folder}/{name}"))


def block(
    jobs: Sequence[Job], swept: Sequence[str], differing: Sequence[str], existing_bits: Sequence[int]
) -> str:
    """Returns the JSON, which is safe within a script element. `existing_bits`: the bits of each job."""
    texts: dict[str, int] = {}

    def text_index(text: str) -> int:
        return texts.setdefault(text, len(texts))

    data: dict[str, Any] = {
        "numbers": [job["number"] for job in jobs],
        "states": [STATES.index(job["state"]) for job in jobs],
        "messages": [text_index(job["message"]) for job in jobs],
        "problems": {at: job["problems"] for at, job in enumerate(jobs) if job["problems"]},
        "checks": [text_index(passed(job["checks"])) for job in jobs],
        "unmet": {
            at: [text_index(f"{mark} {name}") for mark, name in unmet(job["checks"])]
            for at, job in enumerate(jobs)
            if unmet(job["checks"])
        },
        "folders": [job["folder"] for job in jobs],
        "has": existing_bits,
        "columns": _columns(jobs, swept, differing),
    }
    data["texts"] = list(texts)
    text = printable_lines(json.dumps(data, ensure_ascii=False, separators=(",", ":")))
    for letter in "<>&":
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return text


def passed(checks: Mapping[str, Any]) -> str:
    """Returns in words how many checks of a job passed; "" without checks."""
    if not checks:
        return ""
    total = checks["passed"] + len(checks["failed"]) + len(checks["warned"])
    return f"{checks['passed']} of {total} passed"


def unmet(checks: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Returns the checks of a job that failed and that warn, each with its mark."""
    if not checks:
        return []
    return [("✕", name) for name in checks["failed"]] + [("!", name) for name in checks["warned"]]


def _columns(jobs: Sequence[Job], swept: Sequence[str], differing: Sequence[str]) -> list[dict[str, Any]]:
    columns = []
    for key in swept:
        axis, at = places(key, jobs)
        names = {"names": [name for _, name in axis.ticks]} if axis.discrete else {}
        values = [_rounded_number(value) for value in at]
        columns.append({"title": axis.title, "group": "key", "values": values, **names})
    objectives = [_rounded_number(job["objective"]) for job in jobs]
    if any(value is not None for value in objectives):
        columns.append({"title": "objective", "group": "objective", "values": objectives})
    figures = [figures_of(job) for job in jobs]
    for name in differing:
        values = [_rounded_number(row.get(name)) for row in figures]
        group = "checks" if name.startswith("checks_") else "figure"
        columns.append({"title": name_of(name), "group": group, "values": values})
    calls = [job["calls"].get("made") for job in jobs]
    if any(calls):
        columns.append({"title": "calls", "group": "calls", "values": calls})
    return columns


def _rounded_number(value: float | None) -> float | None:
    """Rounds a number to nine digits; returns None for None and for a number that is not finite."""
    if value is None or not math.isfinite(value):
        return None
    return int(value) if float(value).is_integer() and abs(value) < 1e15 else float(f"{value:.{_DIGITS}g}")
